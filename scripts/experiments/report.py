# SPDX-License-Identifier: BSD-3-Clause
"""The page and the table of results."""
import html
import os

from runs import FOLDER, ROOT

STYLE = """body{font:16px/1.5 system-ui,sans-serif;max-width:62rem;margin:2rem auto;padding:0 1rem;color:#222;background:#fff}
h2{margin-top:3rem;border-top:1px solid #8886;padding-top:1rem}figure{margin:1.2rem 0}figcaption{font-size:.9rem;opacity:.8}
table{border-collapse:collapse}td,th{padding:.15rem 1rem .15rem 0;vertical-align:top;text-align:left}
.pass{color:#18794e;font-weight:600}.fail{color:#c62a2f;font-weight:600}svg{max-width:100%;height:auto}ul{padding-left:1.2rem}
.grid{stroke:#999;stroke-width:.5;opacity:.7}code{font-size:.9em}dt{font-weight:600}dd{margin:0 0 .4rem}
@media(prefers-color-scheme:dark){body{color:#ddd;background:#181a1b}a{color:#8ab4f8}.pass{color:#4cc38a}.fail{color:#ff6369}}"""


def get_class(outcome):
    return {'pass': 'pass', 'FAIL': 'fail', 'skipped': ''}[outcome.verdict()]


def make_summary(results):
    rows = ''.join(
        '<tr><td><a href="#%s">%s</a></td><td>%s</td><td>%s</td><td class="%s">%s</td></tr>'
        % (e.name, html.escape(e.title), html.escape('; '.join(o.seen)), o.held, get_class(o), o.verdict()) for e, o in results)
    return ('<table><thead><tr><th>experiment</th><th>here</th><th>of ten</th><th>claims</th></tr></thead><tbody>%s</tbody></table>'
            % rows)


def make_section(experiment, o):
    claims = ''.join('<li><span class="%s">%s</span> %s</li>' % (
        'pass' if holds else 'fail', 'holds:' if holds else 'does not hold:', html.escape(text)) for text, holds in o.claims)
    numbers = ''.join('<tr><th>%s</th><td>%s</td></tr>' % (html.escape(a), html.escape(b)) for a, b in o.numbers)
    figures = ''.join('<figure>%s<figcaption>%s</figcaption></figure>' % (
        svg.replace('<svg ', '<svg role="img" aria-label="%s" ' % html.escape(caption, quote=True), 1), html.escape(caption))
        for caption, svg in o.figures)
    saw = '<dt>The paper saw</dt><dd>%s</dd>' % html.escape(experiment.saw) if experiment.saw else ''
    again = ''
    scenario = find_scenario(experiment.name)
    if scenario:
        again = '<p>Run it again, or change it: <code>scripts/simulate.sh %s</code></p>' % scenario
    if o.log:
        again += '<p>Watch it: <code>scripts/view.sh %s</code></p>' % html.escape(os.path.relpath(o.log, ROOT) if o.log.startswith(ROOT + os.sep) else o.log)
    again = '<p>%s</p>' % html.escape(o.origin) + again
    return ('<section id="%s"><h2>%s <span class="%s">%s</span></h2><dl>%s<dt>We see</dt><dd>%s</dd></dl>%s<ul>%s</ul>'
            '<table>%s</table>%s<p>Took %.0f s.</p></section>'
            % (experiment.name, html.escape(experiment.title), get_class(o), o.verdict(), saw, html.escape('; '.join(o.seen) or '-'),
               figures, claims, numbers, again, o.seconds))


def find_scenario(name):
    for candidate in (name, 'beyond_' + name, 'beyond_10m' if name == 'ten_metres' else name):
        path = os.path.join(FOLDER, candidate + '.yaml')
        if os.path.exists(path):
            return os.path.relpath(path, ROOT)
    return None


def make_page(results, words):
    held = sum(1 for _, o in results if o.verdict() == 'pass')
    return '\n'.join(
        ['<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
         '<title>Do the simulations correspond?</title><style>%s</style>' % STYLE,
         '<h1>Do the simulations correspond?</h1>',
         '<p>Experiments of Hirukawa et al., <i>Experimental Evaluation of the Dynamic Simulation of Biped Walking of Humanoid '
         'Robots</i>, ICRA 2003, and some beyond. All data are simulated. %d of %d experiments pass. %s</p>'
         % (held, len(results), html.escape(words)),
         make_summary(results)] + [make_section(e, o) for e, o in results] + ['</html>', ''])


def make_table(results):
    """Markdown, as in docs/experiments.md."""
    lines = ['| experiment | the paper | here | of ten | claims |', '|---|---|---|---|---|']
    for e, o in results:
        failed = '; '.join(text for text, holds in o.claims if not holds)
        lines.append('| %s | %s | %s | %s | %s |' % (e.name, e.saw, '; '.join(o.seen), o.held,
                                                     {'pass': 'hold', 'skipped': 'not run'}.get(o.verdict(), '**fail**: ' + failed)))
    return '\n'.join(lines) + '\n'
