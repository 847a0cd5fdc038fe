"""One case: the diagnosis against the sealed answer."""
from . import naming, probabilities

# A gauge ties these parameters together: no interval is judged.
NO_INTERVALS = {'link_gravity', 'self_weight_sag', 'gravity_compensator'}
GAP_VERDICTS = {'explained', 'partly', 'unknown'}


def parameter_judgements(step, hidden):
    """z and coverage of every parameter of a rightly named step.

    Where a parameter of the effect is held (left out, without sigma, or known from the prior alone), the others are
    conditional on it and not to be compared.
    """
    estimated = {p['name'] for p in step['parameters'] if p.get('sigma') and p.get('identifiable', True)}
    if hidden['kind'] in NO_INTERVALS or not set(hidden['parameters']) <= estimated:
        return []
    judged = []
    for parameter in step['parameters']:
        truth = hidden['parameters'].get(parameter['name'])
        if truth is None:
            continue
        low, high = parameter['ci95']
        judged.append({'name': '%s/%s' % (hidden['kind'], parameter['name']), 'truth': truth,
                       'value': parameter['value'], 'z': (parameter['value'] - truth) / parameter['sigma'],
                       'inside': low <= truth <= high})
    return judged


def judge(case, sized, answer, diagnosis, separations):
    hidden = [h for h in answer['hidden'] if h['in_catalogue']]
    truths = [naming.identity(h, 'kind') for h in hidden]
    accepted = set(truths)
    for h in hidden:
        accepted |= naming.accepted_besides(h)
    steps = [naming.identity(s) for s in diagnosis['steps']]
    listed = [[naming.identity(a) for a in s['alternatives']] for s in diagnosis['steps']]
    every_name = set(steps).union(*listed) if steps else set()
    parameters = []
    for step, name in zip(diagnosis['steps'], steps):
        if name in truths:
            parameters += parameter_judgements(step, hidden[truths.index(name)])
    best = diagnosis['candidates'][0] if diagnosis['candidates'] else {}
    unexplained = diagnosis.get('unexplained') or {}
    return {
        'suite': case['suite'], 'index': case['index'], 'group': case['group'], 'expects': case['expects'],
        'kinds': case['kinds'], 'flags': sized['flags'], 'scales': sized['scales'], 'nc': sized['nc'],
        'nc_alone': sized['nc_alone'], 'separations': separations,
        'truths': [naming.words(t) for t in truths], 'verdict': diagnosis['verdict'],
        'steps': [naming.words(s) for s in steps], 'listed': [[naming.words(a) for a in row] for row in listed],
        'detected': diagnosis['verdict'] in GAP_VERDICTS or bool(steps),
        'named_first': bool(steps) and steps[0] in truths,
        'all_named': bool(truths) and set(truths) <= set(steps),
        'named_or_listed': bool(truths) and all(t in every_name for t in truths),
        'one_named_or_listed': any(t in every_name for t in truths),
        'exact': bool(truths) and set(truths) <= set(steps) <= accepted and len(steps) == len(set(steps)),
        'said': probabilities.said(diagnosis, truths),
        'parameters': parameters, 'gap_closed': diagnosis['final'].get('gap_closed'),
        'tests': diagnosis.get('screened'), 'lack_of_fit_p': diagnosis['baseline'].get('lack_of_fit_p'), 'best_p': best.get('p_value'),
        'noise': diagnosis['noise'], 'sealed_noise': {
            'scale': answer['sigma_factor'], 'repeatability_urad': answer['undeclared_repeatability_urad'],
            'outliers': answer['outliers'], 'group': answer.get('group')},
        'unexplained': {k: unexplained.get(k) for k in ('words', 'kind', 'depends_on')} if unexplained else None,
        'learnt': unexplained.get('learnt'),
        'baseline_reduced_chi2': diagnosis['baseline'].get('reduced_chi2'),
        'final_reduced_chi2': diagnosis['final'].get('reduced_chi2'),
        'holdout_rms_mm': [diagnosis[when].get('holdout_rms_mm') for when in ('baseline', 'final')]}
