"""What a diagnosis says with which probability, against the sealed answer: log score, reliability, size of the sets."""
import math

from . import naming

LEAST = 1e-6  # of a truth that is not listed: probabilities below 1e-4 are not written
BINS = ((0.0, 0.3), (0.3, 0.5), (0.5, 0.7), (0.7, 0.9), (0.9, 0.99), (0.99, 1.0 + 1e-9))
HELD = 0.95


def smallest_list(sets, nothing):
    """Names, the most useful next, until what they are part of holds 95 %; what has no name counts as one."""
    open_sets = [({naming.identity(e) for e in s['explanations']} or {None}, s['probability']) for s in sets]
    total = nothing + sum(probability for _, probability in open_sets)
    held, listed = nothing, set()
    while held < HELD * total and open_sets:
        worth = {}
        for names, probability in open_sets:
            for name in names:
                worth[name] = worth.get(name, 0.0) + probability
        best = max(worth, key=worth.get)
        listed.add(best)
        held += worth[best]
        open_sets = [(names, probability) for names, probability in open_sets if best not in names]
    return len(listed), listed


def said(diagnosis, truths):
    """Probabilities of one effect being there, of the leading name, and the smallest set of names with 95 %."""
    posterior = diagnosis.get('posterior')
    if posterior is None:
        return None
    ranked = [(naming.identity(e), e['probability']) for e in posterior['explanations']]
    chances = dict(ranked)
    size, listed = smallest_list(diagnosis['sets'], posterior['nothing'] + posterior['noise'])
    truth = truths[0] if len(truths) == 1 else None
    leading = max(ranked, key=lambda entry: entry[1]) if ranked else (None, 0.0)
    return {'nothing': posterior['nothing'], 'noise': posterior['noise'], 'unnamed': posterior['unnamed'],
            'leading': leading[1], 'leading_is_true': leading[0] in truths,
            'truth': chances.get(truth, 0.0) if truth else None,
            'set_size': size, 'set_holds': bool(truths) and all(t in listed for t in truths)}


def reliability(records):
    """Per bin of what was said of the leading name: how many, the mean said, the share that was right."""
    table = []
    for low, high in BINS:
        own = [r['said'] for r in records if r.get('said') and low <= r['said']['leading'] < high]
        if own:
            table.append({'from': low, 'to': min(high, 1.0), 'n': len(own),
                          'said': sum(s['leading'] for s in own) / len(own),
                          'right': sum(s['leading_is_true'] for s in own) / len(own)})
    return table


def summary(records):
    """Of single effects that were detected."""
    own = [r for r in records if r.get('said') and r['said']['truth'] is not None and r['detected']]
    if not own:
        return {}
    n = len(own)
    table = reliability(own)
    return {'n': n, 'log_score': sum(math.log(max(LEAST, r['said']['truth'])) for r in own) / n,
            'mean_largest': sum(r['said']['leading'] for r in own) / n,
            'leading_is_true': sum(r['said']['leading_is_true'] for r in own) / n,
            'set_holds': sum(r['said']['set_holds'] for r in own) / n,
            'set_size': sum(r['said']['set_size'] for r in own) / n, 'reliability': table,
            'calibration_error': sum(b['n'] * abs(b['said'] - b['right']) for b in table) / sum(b['n'] for b in table)}
