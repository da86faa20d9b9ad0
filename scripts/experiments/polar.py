# SPDX-License-Identifier: BSD-3-Clause
"""A plot over directions, as SVG text."""
import math

COLOURS = ('#0072B2', '#D55E00', '#009E73', '#CC79A7')
SIZE, RADIUS = 420, 150


def find_ring(largest):
    """Distance of the rings: about four of them."""
    for ring in (0.5, 1, 2, 5, 10, 20, 50):
        if largest / ring <= 5:
            return ring
    return largest / 4


def draw_polar(degrees, rows, unit):
    """rows: {label: values}, one value a direction; 0 degrees is up, angles grow to the left, as seen from above."""
    largest = max(max(values) for values in rows.values())
    ring = find_ring(largest)
    outer = ring * math.ceil(largest / ring)
    middle = SIZE / 2

    def place(value, angle):
        r, a = RADIUS * value / outer, math.radians(angle)
        return middle - r * math.sin(a), middle - r * math.cos(a)

    height = SIZE + 22 * len(rows)
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 %d %d" width="%d" height="%d" font-family="sans-serif" '
             'font-size="13">' % (SIZE, height, SIZE, height)]
    for k in range(1, round(outer / ring) + 1):
        r = RADIUS * k * ring / outer
        parts.append('<circle class="grid" fill="none" cx="%g" cy="%g" r="%.1f"/>' % (middle, middle, r))
        parts.append('<text x="%.1f" y="%.1f">%g %s</text>' % (middle + 3, middle - r - 3, k * ring, unit))
    for angle in degrees:
        x, y = place(outer, angle)
        parts.append('<line class="grid" x1="%g" y1="%g" x2="%.1f" y2="%.1f"/>' % (middle, middle, x, y))
        x, y = place(1.2 * outer, angle)
        parts.append('<text text-anchor="middle" x="%.1f" y="%.1f">%d°</text>' % (x, y + 4, angle))
    for i, (label, values) in enumerate(rows.items()):
        points = ' '.join('%.1f,%.1f' % place(v, a) for v, a in zip(values, degrees))
        colour, line = COLOURS[i % len(COLOURS)], SIZE + 22 * i
        parts.append('<polygon fill="%s" fill-opacity=".08" stroke="%s" stroke-width="2" points="%s"/>'
                     % (colour, colour, points))
        parts.append('<line x1="20" y1="%d" x2="44" y2="%d" stroke="%s" stroke-width="3"/>' % (line, line, colour))
        parts.append('<text x="52" y="%d">%s</text>' % (line + 4, label))
    return '\n'.join(parts) + '</svg>'
