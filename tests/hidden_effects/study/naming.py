"""When two effects are the same: effect, target and settings, but not those that have any value (times, widths)."""
# A change point lies somewhere between two visits; of the others the search has a few values.
FREE_SETTINGS = {'after_s', 'tau_s', 'lag_s', 'width_deg', 'width_Nm'}
HARMONIC = 'joint_harmonic'


def identity(entry, effect_key='effect'):
    """Tuple that names an effect of diagnosis.json, or (effect_key='kind') of an answer."""
    settings = tuple(sorted((k, str(v)) for k, v in entry.get('settings', {}).items() if k not in FREE_SETTINGS))
    return entry[effect_key], entry['target'], settings


def words(name):
    effect, target, settings = name
    inner = ','.join('%s=%s' % s for s in settings)
    return '%s%s/%s' % (effect, '[%s]' % inner if inner else '', target)


def accepted_besides(hidden):
    """Names that are right in addition to the main one: further harmonics of the same gear."""
    return {(HARMONIC, hidden['target'], (('order', str(n)),)) for n in hidden.get('further_orders', [])}


def named_again(diagnosis, other, leading):
    """One record for each leading step of a diagnosis: how another one of the same arm has it."""
    named = {identity(step) for step in other['steps']}
    listed = named | {identity(a) for step in other['steps'] for a in step['alternatives']}
    on_joint = {(effect, target) for effect, target, _ in named}
    identities = [identity(step) for step in diagnosis['steps'][:leading]]
    return [{'step': words(i), 'named': i in named, 'listed': i in listed, 'same_joint': i[:2] in on_joint}
            for i in identities]


def kinds_of(diagnosis):
    """{effect: probability that the arm has it anywhere}, of its groups; one of several effects has none."""
    return {diagnosis['steps'][group['steps'][0]]['effect']: group['probability']
            for group in diagnosis['groups'] if group['probability'] is not None}


def groups_again(diagnosis, other, sure):
    """One record for each kind of effect of which a diagnosis is sure: how another one of the same arm has it."""
    elsewhere = kinds_of(other)
    return [{'group': effect, 'sure': elsewhere.get(effect, 0.0) >= sure, 'likely': elsewhere.get(effect, 0.0) >= 0.5}
            for effect, chance in sorted(kinds_of(diagnosis).items()) if chance >= sure]
