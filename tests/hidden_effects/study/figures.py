"""The figures of a study, from its records: what the sealed answers say about the diagnoses."""
import math

from . import probabilities
from . import statistics as st

FOREIGN_SUITES = ('foreign', 'strangers', 'newcomers', 'latecomers')  # causes outside the catalogue that real cells have
SIGNIFICANCE = 0.01
SHARE_OF_GATE = 0.25  # of the significance, for the search over effects, divided by the candidates of the case
TYPICAL_TESTS = 300
REPRODUCED = 25.0    # noise-free chi-square left; less is seldom detected
TIE = 6.0            # of the best penalised chi-square: the rule chooses the simpler
# Parameters per effect: degrees of freedom of its test. In catalogue order.
DOF = {'frozen_geometry': 1, 'joint_compliance': 1, 'compliance_hardening': 1, 'transverse_compliance': 2,
       'gravity_compensator': 4, 'link_gravity': 4, 'self_weight_sag': 3, 'base_compliance': 2, 'payload': 1,
       'joint_harmonic': 2, 'axis_wobble': 4, 'encoder_gain': 1, 'joint_coupling': 1, 'backlash': 1, 'joint_slip': 1,
       'thermal_growth': 1, 'station_drift': 6, 'station_scale': 1, 'marker_shift': 3,
       'warm_up': 6, 'station_eccentricity': 4, 'station_range_offset': 1, 'load_com': 3, 'hysteresis': 1,
       'marker_acceptance': 1, 'station_refraction': 1}


def rate(records, predicate):
    """k of n with its exact 95 % interval."""
    k, n = sum(1 for r in records if predicate(r)), len(records)
    low, high = st.clopper_pearson(k, n)
    return {'k': k, 'n': n, 'rate': k / n if n else None, 'ci95': [low, high]}


def finished(records):
    return [r for r in records if 'failed' not in r]


def single(records):
    return [r for r in records if r['expects'] == 'catalogue' and len(r['kinds']) == 1]


def sep_of(record):
    seps = [s['sep'] for s in record['separations'] if s['sep'] is not None]
    return seps[0] if seps else None


def naming_limit(records):
    """mean Phi(sqrt(sep) / 2): how often the better of two known signals wins in this noise."""
    seps = [max(0.0, sep_of(r)) for r in records if sep_of(r) is not None]
    return sum(st.normal_cdf(0.5 * math.sqrt(s)) for s in seps) / len(seps) if seps else None


def rule_handicap(separation, effect, rival):
    """Chi-square by which the truth must lead a rival to be named: penalised p ln(n), within 6 the simpler, then the
    earlier in the catalogue; among targets of one effect the better by Akaike's criterion. Settings are left out."""
    extra = separation['parameters'] - rival['parameters']
    if rival['effect'] == effect:
        return 2.0 * extra
    order = list(DOF)
    rival_is_simpler = extra > 0 or (extra == 0 and order.index(rival['effect']) < order.index(effect))
    return extra * separation['log_rows'] + (TIE if rival_is_simpler else -TIE)


def rule_chance(separation, effect):
    """How often the rule names the truth: against its worst rival, whose lead in noise is N(lead, 4 lead)."""
    chances = [1.0]
    for rival in separation['rivals']:
        lead = max(1e-9, rival['lead'])
        margin = lead - rule_handicap(separation, effect, rival)
        twins = rival['lead'] < 1e-2 and rival['effect'] == effect
        chances.append(0.5 if twins else st.normal_cdf(0.5 * margin / math.sqrt(lead)))
    return min(chances)


def rule_limit(records):
    """mean of rule_chance: what the rule of choosing allows, in data of this sep."""
    known = [r for r in records if sep_of(r) is not None and 'rivals' in r['separations'][0]]
    return sum(rule_chance(r['separations'][0], r['kinds'][0]) for r in known) / len(known) if known else None


def naming(records):
    """By NC and by sep, of single effects of the catalogue."""
    ones = single(records)
    out = {'by_nc': {}, 'by_sep': {}, 'by_kind': {}}
    for label, low, high in (('NC < 20', 0, 20), ('NC 20-40', 20, 40), ('NC 40-100', 40, 100), ('NC >= 100', 100, 1e99),
                             ('NC >= 40', 40, 1e99)):
        chosen = [r for r in ones if low <= r['nc'] < high]
        out['by_nc'][label] = dict(rates_of(chosen), limit=naming_limit(chosen), rule=rule_limit(chosen))
    for label, low, high in (('sep < 3', -1e99, 3), ('sep 3-10', 3, 10), ('sep 10-20', 10, 20), ('sep >= 20', 20, 1e99)):
        chosen = [r for r in ones if r['nc'] >= 40 and sep_of(r) is not None and low <= sep_of(r) < high]
        out['by_sep'][label] = rates_of(chosen)
    for kind in sorted({r['kinds'][0] for r in ones}):
        out['by_kind'][kind] = rates_of([r for r in ones if r['kinds'][0] == kind and r['nc'] >= 40])
    return out


def rates_of(records):
    return {'named_first': rate(records, lambda r: r['named_first']),
            'named_or_listed': rate(records, lambda r: r['named_or_listed']),
            'exact': rate(records, lambda r: r['exact']),
            'detected': rate(records, lambda r: r['detected']),
            'called_unknown': rate(records, lambda r: r['verdict'] == 'unknown')}


def pairs(records):
    twos = [r for r in records if r['expects'] == 'catalogue' and len(r['kinds']) == 2]
    return {'n': len(twos), 'first_is_one_of_them': rate(twos, lambda r: r['named_first']),
            'both_named': rate(twos, lambda r: r['all_named']),
            'both_named_or_listed': rate(twos, lambda r: r['named_or_listed']),
            'exact': rate(twos, lambda r: r['exact']),
            'called_unknown': rate(twos, lambda r: r['verdict'] == 'unknown')}


def power(records):
    """Detection against the power of the chi-square test at the corrected level, by NC."""
    ones = single(records)
    rows = []
    edges = [0, 10, 20, 30, 40, 60, 100, 300, 1e99]
    for low, high in zip(edges, edges[1:]):
        chosen = [r for r in ones if low <= r['nc'] < high]
        if not chosen:
            continue
        predicted = levels = 0.0
        for r in chosen:
            dof = DOF[r['kinds'][0]]
            level = SHARE_OF_GATE * SIGNIFICANCE / (r.get('tests') or TYPICAL_TESTS)
            levels += level / len(chosen)
            predicted += st.noncentral_survival(st.chi_square_quantile_above(level, dof), dof, min(r['nc'], 1000.0))
        rows.append({'nc': [low, high if high < 1e98 else None], 'level': levels, 'curve': predicted / len(chosen),
                     'detected': rate(chosen, lambda r: r['detected'])})
    return {'rows': rows}


def nothing_hidden(records):
    none = [r for r in records if r['expects'] == 'nothing']
    values = [r['lack_of_fit_p'] for r in none if r['lack_of_fit_p'] is not None]
    distance, p = st.kolmogorov_smirnov(values)
    smallest = [r['best_p'] for r in none if r['best_p'] is not None]
    below = {str(level): rate(smallest, lambda v: v <= level) for level in (0.005, 0.01, 0.05, 0.1, 0.5)}
    return {'n': len(none), 'not_consistent': rate(none, lambda r: r['verdict'] != 'consistent'),
            'effect_named': rate(none, lambda r: bool(r['steps'])),
            'verdicts': counted(r['verdict'] for r in none),
            'lack_of_fit_p_uniform': {'ks_distance': distance, 'p': p, 'n': len(values)},
            'smallest_corrected_p_below': below}


def counted(items):
    counts = {}
    for item in items:
        counts[item] = counts.get(item, 0) + 1
    return dict(sorted(counts.items(), key=lambda kv: -kv[1]))


def outside(records):
    out = {}
    chosen = [r for r in records if r['expects'] == 'outside' and r['suite'] not in FOREIGN_SUITES]
    for group in sorted({r['group'] for r in chosen}):
        rows = [r for r in chosen if r['group'] == group]
        out[group] = {'unknown': rate(rows, lambda r: r['verdict'] == 'unknown'),
                      'unknown_or_partly': rate(rows, lambda r: r['verdict'] in ('unknown', 'partly')),
                      'consistent': rate(rows, lambda r: r['verdict'] == 'consistent')}
    strong = [r for r in chosen if r['group'] != 'step' and r['nc'] >= 80]
    out['all but steps, NC >= 80'] = {'unknown': rate(strong, lambda r: r['verdict'] == 'unknown')}
    beyond = [r for r in strong if not in_the_catalogue(r)]
    out['of them beyond the catalogue'] = {'unknown': rate(beyond, lambda r: r['verdict'] == 'unknown')}
    return out


def foreign(records, suite):
    """By kind, and over all: verdicts, what was named first, and whether the named effects helped the rows held out."""
    chosen = [r for r in records if r['suite'] == suite]
    groups = {kind: [r for r in chosen if r['group'] == kind] for kind in sorted({r['group'] for r in chosen})}
    if chosen:
        groups['all'] = chosen
    return {kind: {'n': len(rows), 'verdicts': counted(r['verdict'] for r in rows),
                   'named': counted(r['steps'][0] for r in rows if r['steps']),
                   'holdout_worse': rate([r for r in rows if r['steps']], holdout_is_worse)}
            for kind, rows in groups.items()}


def closed_by_learning(records):
    """Causes without a name, NC >= 200: share of the squared gap on untouched rows that the model with the learnt
    functions closes; that of the steps where none was learnt."""
    rows = [r for r in records if r['expects'] == 'outside' and r['nc'] >= 200]
    closed = [(r.get('learnt') or {}).get('gap_closed') for r in rows]
    closed = [(c if c is not None else r['gap_closed']) or 0.0 for c, r in zip(closed, rows)]
    return {'n': len(rows), 'learnt': rate(rows, lambda r: bool(r.get('learnt'))),
            'median': st.median(closed) if closed else None,
            'most': rate(closed, lambda c: c >= 0.9)}


def holdout_is_worse(record):
    before, after = record['holdout_rms_mm']
    return after > before


def in_the_catalogue(record):
    """The named effects reproduce what was hidden: no data could show otherwise."""
    return record.get('left') is not None and record['left'] < REPRODUCED


def unknown_wrongly(records):
    return rate([r for r in records if r['expects'] == 'catalogue' and r['nc'] >= 40],
                lambda r: r['verdict'] == 'unknown')


def intervals(records):
    rows = [p for r in records if r['expects'] == 'catalogue' and r['nc'] >= 100 for p in r['parameters']]
    worst = max((abs(p['z']) for p in rows), default=None)
    bound = st.normal_quantile(1.0 - 0.005 / len(rows)) if rows else None  # 1 % over all of them, two-sided
    return {'coverage': rate(rows, lambda p: p['inside']), 'worst_z': worst, 'bonferroni_bound': bound,
            'worst': max(rows, key=lambda p: abs(p['z']))['name'] if rows else None}


def gap_closed(records):
    values = [r['gap_closed'] for r in records
              if r['expects'] == 'catalogue' and r['nc'] >= 200 and r['gap_closed'] is not None]
    return {'n': len(values), 'median': st.median(values) if values else None}


def scale_found(record):
    low, high = record['noise']['ci95']
    return low <= record['sealed_noise']['scale'] <= high


def found_group(record):
    """What is said of the readings that have other noise; None: nothing, or of others too."""
    sealed, groups = record['sealed_noise']['group'], record['noise'].get('groups', [])
    same = [g for g in groups if (g['of'], g['name']) == (sealed['of'], sealed['name'])]
    return same[0] if same and len(groups) == 1 else None


def group_in_interval(record):
    found = found_group(record)
    return found is not None and found['ci95'][0] <= record['sealed_noise']['group']['factor'] <= found['ci95'][1]


def wrong_noise(records):
    out = {}
    chosen = [r for r in records if r['expects'] == 'noise' or r['sealed_noise'].get('group')]
    for group in sorted({r['group'] for r in chosen}):
        rows = [r for r in chosen if r['group'] == group]
        entry = {'effect_named': rate(rows, lambda r: bool(r['steps'])),
                 'verdict_noise': rate(rows, lambda r: r['verdict'] == 'noise'),
                 'verdicts': counted(r['verdict'] for r in rows)}
        if group.startswith('sigma'):
            entry['scale_in_interval'] = rate(rows, scale_found)
        if group.endswith('repeatability'):
            entry['repeatability_found'] = rate(rows, lambda r: bool(r['noise'].get('repeatability_urad')))
        if rows[0]['sealed_noise'].get('group'):
            entry['group_found'] = rate(rows, lambda r: found_group(r) is not None)
            entry['group_in_interval'] = rate(rows, group_in_interval)
            entry['truth_named_first'] = rate(rows, lambda r: r['named_first'])
        if group == 'outliers':
            planted = sum(len(r['sealed_noise']['outliers']) for r in rows)
            lines = [set(o.rsplit('/', 1)[-1] for o in r['noise']['outliers']) for r in rows]
            hit = sum(len(found & set(r['sealed_noise']['outliers'])) for found, r in zip(lines, rows))
            entry['outliers'] = {'planted': planted, 'found': hit, 'wrongly': sum(map(len, lines)) - hit}
        out[group] = entry
    return out


def confusion(records):
    """hidden kind -> what was named first (effect only) -> count, NC >= 40."""
    table = {}
    for r in records:
        if r['expects'] == 'nothing' or (r['expects'] != 'noise' and len(r['kinds']) != 1):
            continue
        if r['expects'] == 'catalogue' and r['nc'] < 40:
            continue
        row = table.setdefault(r['kinds'][0] if r['kinds'] else r['group'], {})
        if r['steps']:
            found = r['steps'][0].split('/')[0].split('[')[0]
            if r['expects'] == 'catalogue' and found == r['kinds'][0] and not r['named_first']:
                found += ' (other target or setting)'
        else:
            found = r['verdict']
        row[found] = row.get(found, 0) + 1
    return table


def by_group(records):
    out = {}
    for r in records:
        out.setdefault('%s: %s' % (r['suite'], r['group']), []).append(r)
    return {name: dict(rates_of([r for r in rows if r['expects'] == 'catalogue']), n=len(rows),
                       verdicts=counted(r['verdict'] for r in rows)) for name, rows in out.items()}


def all_figures(records):
    done = finished(records)
    return {'cases': len(records), 'failed': [{'folder': r['folder'], 'why': r['failed']} for r in records if 'failed' in r],
            'nothing_hidden': nothing_hidden(done), 'naming': naming(done), 'pairs': pairs(done), 'power': power(done),
            'outside': outside(done), **{suite: foreign(done, suite) for suite in FOREIGN_SUITES},
            'closed_by_learning': closed_by_learning(done),
            'catalogue_called_unknown': unknown_wrongly(done), 'intervals': intervals(done),
            'gap_closed': gap_closed(done), 'wrong_noise': wrong_noise(done), 'confusion': confusion(done),
            'groups': by_group(done), 'probabilities': probabilities.summary(single(done)), 'seconds': {'median': st.median([r['seconds'] for r in records]),
                                                  'largest': max((r['seconds'] for r in records), default=None)}}
