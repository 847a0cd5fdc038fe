"""Gives each hidden effect the wanted noncentrality.

NC is the chi-square of the noise-free rows under the believed model, from the program's own
calibration: stated sigmas, stated repeatability, the same split. It grows with the square of the size.
"""
import json
import pathlib
import shutil
import tempfile

CLOSE = 0.05           # of the wanted NC
LARGEST_SCALE = 10.0   # times a typical size; beyond, the draw is given up
SMALLEST_NC = 1e-3     # of a typical size
MOST_DRAWS = 300


class CannotSize(Exception):
    pass


def generate(programs, flags, scales, folder):
    flags = dict(flags, scales=','.join('%.9g' % s for s in scales))
    programs.generate(flags, folder / 'case', folder / 'answer')


def noncentrality(programs, folder):
    return programs.chi_square(folder / 'answer' / 'experiment.yaml', folder / 'estimate')


def target_is(folder, number, wanted):
    answer = json.loads((folder / 'answer' / 'answer.json').read_text())
    return wanted is None or answer['hidden'][number]['target'] == wanted


def size_of_one(programs, flags, count, number, wanted_nc, wanted_target, folder):
    scale = 1.0
    for _ in range(8):
        generate(programs, flags, [scale if i == number else 0.0 for i in range(count)], folder)
        if not target_is(folder, number, wanted_target):
            raise CannotSize('another target')
        nc = noncentrality(programs, folder)
        if nc is None or nc < SMALLEST_NC * scale * scale:
            raise CannotSize('invisible')
        if abs(nc / wanted_nc - 1.0) < CLOSE:
            return scale, nc
        scale *= min(10.0, max(0.03, (wanted_nc / nc) ** 0.5))
        if scale > LARGEST_SCALE:
            raise CannotSize('would have to be %g times its typical size' % scale)
    raise CannotSize('no size with NC %g' % wanted_nc)


def make_case(programs, case, folder, answer):
    """Writes the case and returns its flags, scales and NC (of each effect alone, and of all)."""
    kinds = case['kinds']
    flags = dict(case['flags'], kinds=','.join(kinds) or 'none')
    for attempt in range(MOST_DRAWS):
        flags['case'] = case['flags']['case'] + 1000000 * attempt
        with tempfile.TemporaryDirectory() as scratch:
            scratch = pathlib.Path(scratch)
            try:
                sized = [size_of_one(programs, flags, len(kinds), i, case['sizes'][i],
                                     case['wanted_targets'][i] if case['wanted_targets'] else None, scratch)
                         for i in range(len(kinds))]
            except CannotSize:
                continue
            scales = [s for s, _ in sized]
            generate(programs, flags, scales, scratch)
            total = noncentrality(programs, scratch)
            if total is None:
                continue
            for source, target in (('case', folder), ('answer', answer)):
                shutil.rmtree(target, ignore_errors=True)
                shutil.copytree(scratch / source, target)
            return {'flags': flags, 'scales': scales, 'nc_alone': [n for _, n in sized], 'nc': total}
    raise CannotSize('%s: no draw can be given NC %s' % (kinds, case['sizes']))
