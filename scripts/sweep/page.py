# SPDX-License-Identifier: BSD-3-Clause
"""A page that plots the table of a sweep: no scripts, no other files."""
import html
import os

WIDTH, HEIGHT, LEFT, BOTTOM = 420, 240, 56, 40
STYLE = '''body{font:15px sans-serif;max-width:72em;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;font-size:13px}td,th{border:1px solid #ccc;padding:2px 6px;text-align:right}
svg{margin:0 1em 1em 0}.bad{background:#fbd9d3}text{font:11px sans-serif}'''
MOST_ROWS = 500


def stands(row):
    return row['status'] == 'ok' and not row['fallen']


def share(rows):
    return sum(map(stands, rows)) / len(rows)


def group(rows, names):
    groups = {}
    for row in rows:
        groups.setdefault(tuple(row[name] for name in names), []).append(row)
    return groups


def show(value):
    return '%.4g' % value if isinstance(value, float) else str(value)


def find_swept(rows, columns):
    """Columns that differ between runs; seeds are no parameters."""
    return [name for name in columns if name != 'seed' and len({str(row[name]) for row in rows}) > 1]


def frame(title, x_label, y_label, inside):
    middle = LEFT + (WIDTH - LEFT) / 2
    return ('<svg width="%d" height="%d" viewBox="0 -18 %d %d"><text x="%g" y="-5" text-anchor="middle" font-weight="bold">%s</text>'
            '%s<text x="%g" y="%d" text-anchor="middle">%s</text><text transform="rotate(-90)" x="%g" y="12" text-anchor="middle">%s</text></svg>'
            % (WIDTH + 10, HEIGHT + 20, WIDTH + 10, HEIGHT + 20, middle, html.escape(title), inside, middle, HEIGHT - 4,
               html.escape(x_label), -(HEIGHT - BOTTOM) / 2, html.escape(y_label)))


def make_curve(rows, name):
    """Share of runs that stand against one parameter; numbers where they are, words beside each other."""
    groups = sorted(group(rows, [name]).items(), key=lambda item: (isinstance(item[0][0], str), item[0]))
    values = [value for (value,), _ in groups]
    numeric = all(isinstance(value, (int, float)) for value in values)
    low, high = (min(values), max(values)) if numeric else (0, len(values) - 1)
    x = lambda i: LEFT + 12 + (WIDTH - LEFT - 24) * (((values[i] if numeric else i) - low) / (high - low))
    y = lambda part: 4 + (HEIGHT - BOTTOM - 4) * (1 - part)
    points = [(x(i), y(share(members))) for i, (_, members) in enumerate(groups)]
    inside = ''.join('<line x1="%d" x2="%d" y1="%g" y2="%g" stroke="#ddd"/><text x="%d" y="%g" text-anchor="end">%d %%</text>'
                     % (LEFT, WIDTH, y(p), y(p), LEFT - 4, y(p) + 4, 100 * p) for p in (0, 0.5, 1))
    inside += '<polyline points="%s" fill="none" stroke="#1f6fb2" stroke-width="2"/>' % ' '.join('%g,%g' % p for p in points)
    step = max(1, len(values) // 8)
    for i, (px, py) in enumerate(points):
        inside += '<circle cx="%g" cy="%g" r="3" fill="#1f6fb2"/>' % (px, py)
        if i % step == 0:
            inside += '<text x="%g" y="%d" text-anchor="middle">%s</text>' % (px, HEIGHT - BOTTOM + 14, html.escape(os.path.basename(show(values[i]))))
    return frame('Runs that stand', name, 'share', inside)


def make_map(rows, x_name, y_name):
    groups = group(rows, [x_name, y_name])
    xs, ys = (sorted({row[name] for row in rows}, key=lambda v: (isinstance(v, str), v)) for name in (x_name, y_name))
    width, height = (WIDTH - LEFT) / len(xs), (HEIGHT - BOTTOM) / len(ys)
    inside = ''
    for (vx, vy), members in groups.items():
        part = share(members)
        colour = 'rgb(%d,%d,%d)' % (222 - 170 * part, 120 + 50 * part, 90 + 20 * part)
        px, py = LEFT + xs.index(vx) * width, HEIGHT - BOTTOM - (ys.index(vy) + 1) * height
        inside += '<rect x="%g" y="%g" width="%g" height="%g" fill="%s" stroke="#fff"><title>%s, %s: %d of %d stand</title></rect>' % (
            px, py, width, height, colour, html.escape(show(vx)), html.escape(show(vy)), sum(map(stands, members)), len(members))
    for i, v in enumerate(xs):
        if i % max(1, len(xs) // 8) == 0:
            inside += '<text x="%g" y="%d" text-anchor="middle">%s</text>' % (LEFT + (i + 0.5) * width, HEIGHT - BOTTOM + 14, html.escape(os.path.basename(show(v))))
    for i, v in enumerate(ys):
        if i % max(1, len(ys) // 8) == 0:
            inside += '<text x="%d" y="%g" text-anchor="end">%s</text>' % (LEFT - 4, HEIGHT - BOTTOM - (i + 0.5) * height + 4, html.escape(show(v)))
    return frame('Green: all stand; red: all fall', x_name, y_name, inside)


def make_table(rows, columns):
    names = ['run'] + list(columns) + ['status', 'fallen', 'fall_time', 'duration', 'largest_lean', 'travelled_x', 'fault']
    lines = ''.join('<tr%s>%s</tr>' % ('' if stands(row) else ' class="bad"', ''.join('<td>%s</td>' % html.escape(show(row.get(name, ''))) for name in names))
                    for row in rows[:MOST_ROWS])
    note = '<p>The first %d of %d runs; table.csv has all.</p>' % (MOST_ROWS, len(rows)) if len(rows) > MOST_ROWS else ''
    return '<table><tr>%s</tr>%s</table>%s' % (''.join('<th>%s</th>' % html.escape(name) for name in names), lines, note)


def make_page(title, rows, columns, words):
    swept = find_swept(rows, columns)
    plots = [make_curve(rows, name) for name in swept]
    plots += [make_map(rows, a, b) for i, a in enumerate(swept) for b in swept[i + 1:]]
    return ('<!doctype html><meta charset="utf-8"><title>%s</title><style>%s</style><h1>%s</h1><p>%d runs, %d stand to their end. %s</p>%s%s'
            % (html.escape(title), STYLE, html.escape(title), len(rows), sum(map(stands, rows)), html.escape(words), ''.join(plots),
               make_table(rows, columns)))
