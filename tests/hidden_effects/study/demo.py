"""One sealed case for people: gap map, name, gap bar before and after, seal opened."""
import argparse
import hashlib
import json
import pathlib
import shutil
import sys

from . import cases, judgement, naming, programs, sizing

WIDTH = 46
STUDY = 20  # streams of its own, apart from the studies'
NC = 1500.0
KINDS = [k for k in cases.CATALOGUE if k not in ('self_weight_sag', 'station_scale')]
ORDER = ['joint', 'load', 'station', 'time', 'axis', 'marker', 'config']


class Paper:
    """Text with colour where it is a terminal."""

    def __init__(self, stream):
        self.stream = stream
        self.colour = stream.isatty()

    def say(self, text=''):
        print(text, file=self.stream, flush=True)

    def paint(self, code, text):
        return '\033[%sm%s\033[0m' % (code, text) if self.colour else text

    def title(self, text):
        self.say()
        self.say(self.paint('1', text))


def bar(value, whole, width=WIDTH):
    return '█' * max(0, min(width, round(width * value / whole))) if whole > 0 else ''


def seal_of(answer):
    return hashlib.sha256((answer / 'answer.json').read_bytes()).hexdigest()


def show_map(paper, where):
    paper.title('Where the gap is (share of the excess chi-square)')
    if not where:
        paper.say('  nowhere: there is none')
    for by in sorted({w['by'] for w in where}, key=lambda b: ORDER.index(b) if b in ORDER else len(ORDER)):
        rows = sorted((w for w in where if w['by'] == by), key=lambda w: -w['share_of_excess'])[:6]
        for i, row in enumerate(rows):
            share = row['share_of_excess']
            if share < 0.01:
                break
            paper.say('  %-8s %-14s %s %3.0f %%' % (by if i == 0 else '', row['key'],
                                                    paper.paint('33', '%-24s' % bar(share, 1.0, 24)), 100 * share))


def show_steps(paper, diagnosis):
    paper.title('What it says')
    paper.say('  ' + diagnosis['words'])
    for number, step in enumerate(diagnosis['steps'], 1):
        paper.say('  step %d: %s' % (number, paper.paint('1;36', naming.words(naming.identity(step)))))
        for parameter in step['parameters']:
            low, high = parameter['ci95']
            paper.say('      %-20s %10.4g   95 %% [%.4g, %.4g]' % (parameter['name'], parameter['value'], low, high))
        for other in step['alternatives'][:4]:
            paper.say('      or %s (overlap %.2f)' % (naming.words(naming.identity(other)), other['overlap']))


def show_gap(paper, diagnosis):
    before = diagnosis['baseline']['holdout_rms_mm']
    after, floor = diagnosis['final']['holdout_rms_mm'], diagnosis['final']['noise_floor_mm']
    paper.title('On configurations that nothing was fitted to (RMS, mm)')
    for label, value, code in (('before', before, '31'), ('after', after, '32'), ('noise floor', floor, '90')):
        paper.say('  %-12s %s %.4f' % (label, paper.paint(code, '%-*s' % (WIDTH, bar(value, max(before, after, floor)))),
                                       value))
    paper.say('  gap closed   %.1f %%' % (100 * diagnosis['final']['gap_closed']))


def open_seal(paper, answer, diagnosis, sealed):
    paper.title('The seal is opened')
    unchanged = seal_of(answer) == sealed
    paper.say('  sha256 %s, %s' % (seal_of(answer)[:16], 'unchanged' if unchanged else 'CHANGED'))
    content = json.loads((answer / 'answer.json').read_text())
    hidden = content['hidden'][0]
    truth = naming.identity(hidden, 'kind')
    paper.say('  hidden: %s' % paper.paint('1;36', naming.words(truth)))
    found = {p['name']: p for s in diagnosis['steps'] if naming.identity(s) == truth for p in s['parameters']}
    for name, value in hidden['parameters'].items():
        told = '   found %.4g ± %.2g' % (found[name]['value'], 2 * found[name]['sigma']) if found.get(name) else ''
        paper.say('      %-20s %10.4g%s' % (name, value, told))
    case = {'suite': 'demo', 'index': 0, 'group': 'demo', 'expects': 'catalogue', 'kinds': [hidden['kind']]}
    record = judgement.judge(case, {'flags': {}, 'scales': [], 'nc': None, 'nc_alone': []}, content, diagnosis, [])
    if record['exact']:
        result = 'named, and nothing else'
    elif record['all_named']:
        result = 'named, with other steps'
    elif record['named_or_listed']:
        result = 'not named, but listed as an alternative that these data cannot distinguish'
    else:
        result = 'missed'
    paper.say('  ' + paper.paint('1;32' if record['named_or_listed'] else '1;31', result))
    return record['named_or_listed'] and unchanged


def arguments(argv):
    parser = argparse.ArgumentParser(prog='tools/demo-hidden-effect', description=__doc__)
    parser.add_argument('--seed', type=int, default=4, help='draws the effect, the design and the noise')
    parser.add_argument('--kind', choices=KINDS, help='do not draw the effect')
    parser.add_argument('--out', type=pathlib.Path, default=pathlib.Path('results/hidden_effect'))
    parser.add_argument('--build', type=pathlib.Path, default=pathlib.Path('build/release/bin'),
                        help='folder of the programs')
    return parser.parse_args(argv)


def main(argv):
    options = arguments(argv)
    paper = Paper(sys.stdout)
    run = programs.Programs(options.build)
    draw = cases.draw_of('demo', STUDY, options.seed)
    kind = draw.choice(KINDS)
    kind = options.kind or kind
    case = cases.case('demo', STUDY, options.seed, [kind], [NC], {'robot': 'kr270', 'configurations': 60}, 'demo')
    folder, answer = options.out / 'case', options.out / 'sealed'
    shutil.rmtree(options.out, ignore_errors=True)
    sizing.make_case(run, case, folder, answer)
    sealed = seal_of(answer)
    paper.title('A simulated KR 270 has one effect that its model lacks')
    paper.say('  seed %d; %s, measurements.csv, experiment.yaml in %s' % (options.seed, 'robot.yaml', folder))
    paper.say('  sealed answer: sha256 %s' % sealed[:16])
    paper.say('  $ sagitta diagnose %s --out=%s' % (folder / 'experiment.yaml', options.out / 'diagnosis'))
    diagnosis, message, seconds = run.diagnose(folder / 'experiment.yaml', options.out / 'diagnosis')
    if diagnosis is None:
        sys.exit('the diagnosis failed: %s' % message)
    paper.say('  %.1f s' % seconds)
    show_map(paper, diagnosis['where'])
    show_steps(paper, diagnosis)
    show_gap(paper, diagnosis)
    good = open_seal(paper, answer, diagnosis, sealed)
    paper.say()
    paper.say('  %s: the page to read first' % (options.out / 'diagnosis' / 'report.html'))
    return 0 if good else 1
