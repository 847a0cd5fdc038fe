"""The figures as text."""


def share(entry):
    if not entry['n']:
        return '-'
    return '%d/%d = %.1f %% [%.1f, %.1f]' % (entry['k'], entry['n'], 100 * entry['rate'], 100 * entry['ci95'][0],
                                             100 * entry['ci95'][1])


def percent(value):
    return '-' if value is None else '%.1f %%' % (100 * value)


def block(title, lines):
    return ['', title, '-' * len(title)] + lines


def limit_of_the_data(rates):
    return '  limit of the data %s' % percent(rates['limit']) if rates.get('limit') is not None else ''


def naming_lines(table):
    lines = []
    for label, rates in table.items():
        if not rates['detected']['n']:
            continue
        limits = limit_of_the_data(rates)
        limits += ', of the rule %s' % percent(rates['rule']) if rates.get('rule') is not None else ''
        lines.append('%-22s first %s%s' % (label, share(rates['named_first']), limits))
        lines.append('%22s named or listed %s, exactly %s, unknown %s' % (
            '', share(rates['named_or_listed']), share(rates['exact']), share(rates['called_unknown'])))
    return lines


def confusion_lines(table):
    lines = []
    for kind, row in table.items():
        total = sum(row.values())
        ordered = sorted(row.items(), key=lambda kv: -kv[1])
        lines.append('%-22s %3d: %s' % (kind, total, ', '.join('%s %d' % item for item in ordered)))
    return lines


def null_lines(f):
    lines = ['any verdict but consistent  %s' % share(f['not_consistent']),
             'an effect named             %s' % share(f['effect_named']),
             'verdicts                    %s' % f['verdicts'],
             'lack-of-fit p uniform       KS %.3f, p %.3g (%d values)' % (
                 f['lack_of_fit_p_uniform']['ks_distance'], f['lack_of_fit_p_uniform']['p'],
                 f['lack_of_fit_p_uniform']['n'])]
    for level, found in f['smallest_corrected_p_below'].items():
        lines.append('smallest corrected p <= %-5s %s' % (level, share(found)))
    return lines


def power_lines(f):
    lines = []
    for row in f['rows']:
        high = '%g' % row['nc'][1] if row['nc'][1] else 'up'
        lines.append('NC %4g to %-4s detected %s   curve %s at level %.2g' % (
            row['nc'][0], high, share(row['detected']), percent(row['curve']), row['level']))
    return lines


def noise_lines(table):
    lines = []
    for group, f in table.items():
        lines.append('%-14s effect named %s, verdict noise %s' % (group, share(f['effect_named']),
                                                                 share(f['verdict_noise'])))
        for key in ('scale_in_interval', 'repeatability_found', 'group_found', 'group_in_interval',
                    'truth_named_first'):
            if key in f:
                lines.append('%14s %s %s' % ('', key.replace('_', ' '), share(f[key])))
        if 'outliers' in f:
            lines.append('%14s outliers %s' % ('', f['outliers']))
        lines.append('%14s %s' % ('', f['verdicts']))
    return lines


def probability_lines(p):
    lines = ['%d cases: mean log p(truth) %.3f; the leading name is right in %.3f, said %.3f; calibration error %.3f' % (
        p['n'], p['log_score'], p['leading_is_true'], p['mean_largest'], p['calibration_error']),
        'the 95 %% set holds the truth in %.3f, with %.2f names' % (p['set_holds'], p['set_size'])]
    return lines + ['said %.2f to %.2f: %d, mean %.3f, right %.3f' % (
        b['from'], b['to'], b['n'], b['said'], b['right']) for b in p['reliability']]


def foreign_lines(table):
    lines = []
    for kind, f in table.items():
        lines.append('%-18s %3d: %s; hold-out worse %d of %d' % (
            kind, f['n'], ', '.join('%s %d' % item for item in f['verdicts'].items()), f['holdout_worse']['k'],
            f['holdout_worse']['n']))
        if kind != 'all' and f['named']:
            lines.append('%23s first named %s' % ('', ', '.join('%s %d' % item for item in f['named'].items())))
    return lines


def summary(figures):
    lines = ['%d cases, %d failed; %.1f s per case (median), %.1f s at most' % (
        figures['cases'], len(figures['failed']), figures['seconds']['median'], figures['seconds']['largest'])]
    lines += ['FAILED %(folder)s: %(why)s' % f for f in figures['failed']]
    if figures['nothing_hidden']['n']:
        lines += block('Nothing hidden', null_lines(figures['nothing_hidden']))
    if figures['naming']['by_kind']:
        lines += block('One effect of the catalogue, by NC', naming_lines(figures['naming']['by_nc']))
        lines += block('By sep, NC >= 40', naming_lines(figures['naming']['by_sep']))
        lines += block('By kind, NC >= 40', naming_lines(figures['naming']['by_kind']))
        lines += block('Detection against the power curve', power_lines(figures['power']))
    if figures.get('probabilities'):
        lines += block('Probabilities, of single effects that were detected', probability_lines(figures['probabilities']))
    two = figures['pairs']
    if two['n']:
        lines += block('Two effects at once', ['%-24s %s' % (k.replace('_', ' '), share(two[k])) for k in two if k != 'n'])
    if any(f['unknown']['n'] for f in figures['outside'].values()):
        lines += block('Outside the catalogue', ['%-26s %s' % (
            g, ', '.join('%s %s' % (k.replace('_', ' '), share(v)) for k, v in f.items()))
            for g, f in figures['outside'].items()])
    for suite, title in (('foreign', 'Foreign causes'), ('strangers', 'Foreign causes, the second list'),
                         ('newcomers', 'Foreign causes, the third list'),
                         ('latecomers', 'Foreign causes, the fourth list')):
        if figures[suite]:
            lines += block(title, foreign_lines(figures[suite]))
    learnt = figures['closed_by_learning']
    if learnt['n']:
        lines += block('Without a name, NC >= 200: the gap on untouched rows', [
            'functions learnt %s; squared gap closed, median %.3f; 0.9 or more of it %s' % (
                share(learnt['learnt']), learnt['median'], share(learnt['most']))])
    if figures['wrong_noise']:
        lines += block('Wrong noise', noise_lines(figures['wrong_noise']))
    if figures['catalogue_called_unknown']['n']:
        i = figures['intervals']
        over = ['catalogue truth called unknown, NC >= 40   %s' % share(figures['catalogue_called_unknown']),
                '95 %% intervals cover, NC >= 100            %s' % share(i['coverage'])]
        if i['worst_z'] is not None:
            over.append('worst z %.2f (%s), Bonferroni bound %.2f' % (i['worst_z'], i['worst'], i['bonferroni_bound']))
        closed = figures['gap_closed']
        if closed['n']:
            over.append('hold-out gap closed, NC >= 200, median     %.3f (%d cases)' % (closed['median'], closed['n']))
        lines += block('Over all catalogue truths', over)
    if figures['confusion']:
        lines += block('Confusion: hidden, then what was named first', confusion_lines(figures['confusion']))
    return '\n'.join(lines)
