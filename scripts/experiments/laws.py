# SPDX-License-Identifier: BSD-3-Clause
"""Figures 4 to 11 once more with the paper's own contact law, the wrench of a pair, beside the points of the other experiments."""
import re

from experiment import Experiment, upright
from hrp2p import calc_inward_torques, calc_medians, find_landings
from joints import calc_band, find_plateaus
from swing import HRP1S_SWING, HRP2P_SWING, calc_errors, measure_swing
from walk_views import LEFT

FIGURES = ('fig4', 'fig4_hrp2p', 'fig5', 'fig6', 'fig7', 'fig8', 'fig9', 'fig10', 'fig11')
# Soft feet without soles of their own dip and lift their corners by centimetres: all of these take part. C along the floor
# is as large as creeping allows: 100 N make 1 mm/s.
WRENCH = {'model': 'wrench', 'stiffness': '2.0e6', 'tangential_damping': '1.0e5', 'margin': '0.04'}


def set_contact(text, keys):
    return re.sub(r'(?m)^contact: .*', 'contact: {%s}' % ', '.join('%s: %s' % pair for pair in keys.items()), text)


def tell_swing(swing):
    def tell(s, c):
        errors = calc_errors(measure_swing(c, swing)[0], swing)
        return 'K %+.1f %%, C %+.1f %%' % tuple(100 * e for e in errors)
    return tell


def tell_plateaus(s, c):
    swing, single = find_plateaus(c, LEFT)
    return '%.0f N in swing, %.0f N in single support; %.0f N rms from 25 to 100 Hz' % (swing, single, calc_band(c, LEFT))


def tell_landing(s, c):
    return 'landing %.0f, %.0f, %.0f N' % tuple(calc_medians(find_landings(c)))


MORE = {'fig4': tell_swing(HRP1S_SWING), 'fig4_hrp2p': tell_swing(HRP2P_SWING),
        'fig6': lambda s, c: '%.0f N rms from 25 to 100 Hz' % calc_band(c, LEFT), 'fig7': tell_plateaus,
        'fig10': lambda s, c: '%.1f and %.1f N m inward' % tuple(calc_inward_torques(c)), 'fig11': tell_landing}


def describe(name, summary, columns):
    if summary['fallen']:
        return 'falls at %.2f s' % summary['fall_time']
    text = 'upright, largest lean %.3f rad' % summary['largest_lean']
    return text + ('; ' + MORE[name](summary, columns) if name in MORE else '')


def laws(run, out):
    stood = {}
    for name in FIGURES:
        text = run.text(name)
        for law, changed in (('points', text), ('wrench', set_contact(text, WRENCH))):
            summary, columns = run.trial('%s_%s' % (name, law), changed, True)
            stood[name, law] = upright(summary)
            out.number('%s, %s' % (name, law), describe(name, summary, columns))
    for name in ('fig4', 'fig4_hrp2p', 'fig7', 'fig9', 'fig10', 'fig11'):
        out.claim('%s: upright with both laws' % name, stood[name, 'points'] and stood[name, 'wrench'])
    out.claim('fig8: falls with both laws', not stood['fig8', 'points'] and not stood['fig8', 'wrench'])
    out.see('; '.join('%s %s' % (name, 'as with points' if stood[name, 'wrench'] == stood[name, 'points'] else
                                 'upright with the wrench, falls with points' if stood[name, 'wrench'] else
                                 'falls with the wrench, upright with points') for name in FIGURES))


# Equations of the paper's law that figure 11's landing is tried without.
TERMS = (('all of it', {}), ('without equation 3 (alpha 0)', {'alpha': '0'}),
         ('without equation 2 (two-sided damper)', {'damping': 'two_sided'}),
         ('equation 3 with n = 2, as strong at 1 mm', {'exponent': '2', 'alpha': '2400'}),
         ('equation 3 ten times as strong', {'alpha': '24'}))


def terms(run, out):
    """Figure 11 with the paper's law: which equation shapes the landing?"""
    found = {}
    for words, keys in TERMS + (('without equation 5 about roll and pitch', None),):
        text = set_contact(run.text('fig11'), dict(WRENCH, **(keys or {})))
        if keys is None:
            text = re.sub(r'c_roll: \d+', 'c_roll: 0', re.sub(r'c_pitch: \d+', 'c_pitch: 0', text))
        summary, columns = run.trial('fig11_terms', text, True)
        found[words] = calc_medians(find_landings(columns)) if upright(summary) else None
        out.number(words, 'falls at %.2f s' % summary['fall_time'] if not found[words] else '%.0f, %.0f, %.0f N' % tuple(found[words]))
    whole, without = found[TERMS[0][0]], found[TERMS[1][0]]
    out.claim('walks with all of it and without equation 3', whole and without)
    if whole and without:
        out.see('peak, dip and load with all of it %.0f, %.0f, %.0f N; without equation 3 %.0f, %.0f, %.0f N' % (*whole, *without))
        out.claim('equation 3 makes the rebound smaller: the dip is higher by more than 10 N and the second peak lower by more '
                  'than 10 N', whole[1] > without[1] + 10.0 and whole[2] < without[2] - 10.0)


EXPERIMENTS = [
    Experiment('laws', 'Figures 4 to 11 with both contact laws',
               'One contact law, a wrench of each pair (equations 1 to 6), for all figures.', laws, cost=30.0),
    Experiment('terms', 'Figure 11: which equation shapes the landing',
               'The damper is non-linear, so that the force is continuous and does not stick.', terms, cost=12.0),
]
