"""sep: the noise-free chi-square lead of the true effect over its best rival, after refit.

The believed model of the noise-free rows is extended by the truth, and by each of the rivals that the
diagnosis itself put forward, and calibrated; sep is the smallest chi-square with a rival minus that with the truth.
Every rival's lead is kept, with its number of parameters: the rule of choosing has a limit of its own (figures.py).
"""
import math
import pathlib
import re
import shutil
import tempfile

from . import naming

TARGET_KEY = {'frozen_geometry': 'error', 'payload': 'load', 'station_drift': 'station', 'station_scale': 'station',
              'marker_shift': 'marker', 'warm_up': 'station', 'station_eccentricity': 'station',
              'station_range_offset': 'station', 'load_com': 'load', 'marker_acceptance': 'marker',
              'station_refraction': 'station'}
NO_TARGET = {'base_compliance', 'thermal_growth'}
PARAMETERS = {
    'compliance_hardening': ['k3_urad_per_kNm3'], 'transverse_compliance': ['ku_urad_per_Nm', 'kv_urad_per_Nm'],
    'link_gravity': ['mass_kg', 'mx_kgm', 'my_kgm', 'mz_kgm'], 'base_compliance': ['kx_urad_per_Nm', 'ky_urad_per_Nm'],
    'payload': ['dmass_kg'], 'joint_harmonic': ['cos_urad', 'sin_urad'], 'encoder_gain': ['gain_ppm'],
    'axis_wobble': ['u_cos_urad', 'u_sin_urad', 'v_cos_urad', 'v_sin_urad'], 'joint_coupling': ['ratio_ppm'],
    'backlash': ['half_gap_urad'], 'joint_slip': ['jump_urad'], 'thermal_growth': ['growth_ppm_per_K'],
    'station_drift': ['x_um_per_h', 'y_um_per_h', 'z_um_per_h', 'rx_urad_per_h', 'ry_urad_per_h', 'rz_urad_per_h'],
    'station_scale': ['scale_ppm'], 'marker_shift': ['x_mm', 'y_mm', 'z_mm'],
    'warm_up': ['x_um', 'y_um', 'z_um', 'rx_urad', 'ry_urad', 'rz_urad'],
    'station_eccentricity': ['az_cos_urad', 'az_sin_urad', 'el_cos_urad', 'el_sin_urad'],
    'station_range_offset': ['offset_um'], 'load_com': ['dx_mm', 'dy_mm', 'dz_mm'], 'hysteresis': ['amplitude_urad'],
    'marker_acceptance': ['offset_um'], 'station_refraction': ['curvature_urad_per_m']}
SPRING = {'L_mm': 184.72, 'a_x_mm': 685.93, 'a_y_mm': 123.30, 's0_mm': 458, 'Kc_N_per_mm': 1}
MOST_RIVALS = 12


def yaml_entry(effect, target, settings, joints):
    fields = ['effect: %s' % effect]
    if effect not in NO_TARGET:
        fields.append('%s: %s' % (TARGET_KEY.get(effect, 'joint'), target))
    fields += ['%s: %s' % s for s in settings.items()]
    names = PARAMETERS.get(effect, [])
    if effect == 'self_weight_sag':
        names = ['s%d%s_urad' % (i + 1, a) for i in range(joints.index(target), len(joints)) for a in 'xyz']
    fields += ['%s: 0' % n for n in names]
    return '  - {%s}' % ', '.join(fields)


def add_to_list(text, key, name):
    """`  key: [a, b]` of experiment.yaml with one more name; the line is added where it is missing."""
    line = re.compile(r'^  %s: \[(.*)\]$' % key, re.MULTILINE)
    if line.search(text):
        return line.sub(lambda m: '  %s: [%s]' % (key, m.group(1) + ', ' + name if m.group(1) else name), text)
    return text.replace('\nvalidation:', '\n  %s: [%s]\nvalidation:' % (key, name))


def extend(answer, out, effects):
    """The noise-free case with these effects (effect, target, settings, values) believed."""
    shutil.copytree(answer, out, dirs_exist_ok=True)
    robot, experiment = (out / 'robot.yaml').read_text(), (out / 'experiment.yaml').read_text()
    joints = re.findall(r'\{name: (\w+), type', robot)
    entries = []
    for effect, target, settings, values in effects:
        if effect == 'frozen_geometry':
            experiment = add_to_list(experiment, 'geometry', target)
        elif effect == 'joint_compliance':
            experiment = add_to_list(experiment, 'compliance', target)
        elif effect == 'gravity_compensator':
            spring = dict(SPRING, **{k: v for k, v in values.items() if k in SPRING})
            fields = ', '.join('%s: %.9g' % s for s in spring.items())
            robot += 'gravity_compensator:\n  {joint: %s, type: spring, %s, preload: true}\n' % (target, fields)
            experiment = add_to_list(experiment, 'gravity_compensator', 'a_x, a_y, s0, Kc')
        else:
            entries.append(yaml_entry(effect, target, settings, joints))
    if entries:
        if '\neffects:\n' not in robot:
            robot += 'effects:\n'
        robot = robot.replace('\neffects:\n', '\neffects:\n' + '\n'.join(entries) + '\n')
    (out / 'robot.yaml').write_text(robot)
    (out / 'experiment.yaml').write_text(experiment)


def fit_with(programs, answer, effects):
    """The fit of the noise-free rows (`fit` of estimate.json) with these effects; None: no estimate."""
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        extend(answer, scratch / 'case', effects)
        estimate = programs.calibrated(scratch / 'case' / 'experiment.yaml', scratch / 'estimate')
    return None if estimate is None else estimate['fit']


def log_rows(fit):
    return math.log(3 * fit['observations'])


def as_effect(entry, key):
    return entry[key], entry['target'], entry.get('settings', {}), values_of(entry)


def values_of(entry):
    values = entry.get('parameters') or {}
    return values if isinstance(values, dict) else {p['name']: p['value'] for p in values}


def candidate_rivals(diagnosis, truths):
    """Steps, their alternatives and the best candidates; each name once, truths left out."""
    found = []
    for step in diagnosis['steps']:
        found.append(step)
        found += step['alternatives']
    found += diagnosis['candidates']
    seen, rivals = set(truths), []
    for entry in found:
        name = naming.identity(entry)
        if name not in seen:
            seen.add(name)
            rivals.append(as_effect(entry, 'effect'))
    return rivals[:MOST_RIVALS]


def left_by_steps(programs, answer_folder, diagnosis):
    """Chi-square of the noise-free rows that the model with the diagnosed steps leaves: near zero, the catalogue holds
    what was hidden, whatever the generator calls it (a neighbour's harmonic is an axis wobble)."""
    fit = fit_with(programs, answer_folder, [as_effect(step, 'effect') for step in diagnosis['steps']])
    return None if fit is None else fit['chi2']


def own_parameters(effect, fit, without):
    """How many parameters of an effect the data determine; a compensator's shape is searched, so all four count."""
    if effect == 'gravity_compensator':
        return 4
    return max(1, fit['free_parameters'] - without['free_parameters']) if without else 1


def separation(programs, answer_folder, hidden, number, diagnosis):
    """{'sep', 'best_rival', 'left', 'log_rows', 'parameters', 'rivals': [{'effect', 'name', 'lead', 'parameters'}]}:
    the smallest lead, over whom, the chi-square that the truth itself leaves, and what the rule of choosing needs.

    The model without any of them is a rival too.
    """
    truths = [naming.identity(h, 'kind') for h in hidden]
    others = [as_effect(h, 'kind') for i, h in enumerate(hidden) if i != number]
    true = fit_with(programs, answer_folder, others + [as_effect(hidden[number], 'kind')])
    if true is None:
        return {'sep': None, 'best_rival': None, 'left': None, 'rivals': []}
    without = fit_with(programs, answer_folder, others)
    rivals = []
    for rival in candidate_rivals(diagnosis, truths):
        fit = fit_with(programs, answer_folder, others + [rival])
        if fit is not None:
            name = naming.identity({'effect': rival[0], 'target': rival[1], 'settings': rival[2]})
            rivals.append({'effect': rival[0], 'name': naming.words(name), 'lead': fit['chi2'] - true['chi2'],
                           'parameters': own_parameters(rival[0], fit, without)})
    leads = [(r['lead'], r['name']) for r in rivals]
    if without is not None:
        leads.append((without['chi2'] - true['chi2'], 'nothing'))
    sep, who = min(leads, default=(None, None))
    return {'sep': sep, 'best_rival': who, 'left': true['chi2'], 'log_rows': log_rows(true),
            'parameters': own_parameters(hidden[number]['kind'], true, without), 'rivals': rivals}
