"""Runs the cases of a suite, two at a time; what is done already is kept."""
import concurrent.futures
import json
import os
import sys
import tempfile

from . import judgement, rivals, sizing


def write_json(path, value):
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile('w', dir=path.parent, delete=False) as file:
        json.dump(value, file, indent=1)
    os.replace(file.name, path)


class Folders:
    """work/SUITE-seedN/{cases,answers,results,records}/caseNNN"""

    def __init__(self, work, suite, seed):
        self.root = work / ('%s-seed%d' % (suite, seed))

    def of(self, what, index):
        return self.root / what / ('case%04d' % index)

    def record(self, index):
        return self.root / 'records' / ('case%04d.json' % index)


def prepared(programs, case, folders):
    """Generates the case unless the same one lies there."""
    seal = folders.of('answers', case['index']) / 'sized.json'
    if seal.exists():
        known = json.loads(seal.read_text())
        if known['case'] == json.loads(json.dumps(case)):
            return known['sized']
    sized = sizing.make_case(programs, case, folders.of('cases', case['index']), folders.of('answers', case['index']))
    write_json(seal, {'case': case, 'sized': sized})
    return sized


def run_case(programs, case, folders, with_separation):
    index = case['index']
    record_path = folders.record(index)
    fingerprint = programs.fingerprint()
    sized = prepared(programs, case, folders)
    if record_path.exists():
        record = json.loads(record_path.read_text())
        if record.get('program') == fingerprint and record.get('flags') == sized['flags']:
            return record
    results = folders.of('results', index)
    experiment = folders.of('cases', index) / 'experiment.yaml'
    diagnosis, message, seconds = programs.diagnose(experiment, results)
    if diagnosis is None:
        record = {'suite': case['suite'], 'index': index, 'group': case['group'], 'expects': case['expects'],
                  'kinds': case['kinds'], 'flags': sized['flags'], 'nc': sized['nc'], 'failed': message}
    else:
        answer_folder = folders.of('answers', index)
        answer = json.loads((answer_folder / 'answer.json').read_text())
        separations = []
        if with_separation and case['expects'] == 'catalogue':
            separations = [rivals.separation(programs, answer_folder, answer['hidden'], i, diagnosis)
                           for i in range(len(answer['hidden']))]
        record = judgement.judge(case, sized, answer, diagnosis, separations)
        if with_separation and case['expects'] == 'outside' and diagnosis['steps']:
            record['left'] = rivals.left_by_steps(programs, answer_folder, diagnosis)
    record.update(program=fingerprint, seconds=round(seconds, 2), folder=str(folders.of('cases', index)))
    write_json(record_path, record)
    return record


def line_of(record):
    if 'failed' in record:
        return 'FAILED %s' % record['failed']
    mark = ''
    if record['expects'] == 'catalogue':
        mark = 'right' if record['exact'] else 'listed' if record['named_or_listed'] else 'missed'
    hidden = '+'.join(record['truths'] or record['kinds'] or ['nothing'])
    seps = ['%.1f' % s['sep'] for s in record['separations'] if s['sep'] is not None]
    return '%-9s %-6s NC %6.1f sep %-9s %5.1f s  hidden %s  found %s' % (
        record['verdict'], mark, record['nc'] or 0.0, ','.join(seps) or '-', record['seconds'], hidden,
        ' + '.join(record['steps']) or '-')


def run_suite(programs, cases, folders, jobs, with_separation, quiet=False):
    """Records of all cases; those whose effect cannot be given the size that is asked are said and left out."""
    cases = list(cases)
    records = [None] * len(cases)
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        futures = {pool.submit(run_case, programs, case, folders, with_separation): i for i, case in enumerate(cases)}
        for done, future in enumerate(concurrent.futures.as_completed(futures), 1):
            i = futures[future]
            try:
                records[i] = future.result()
            except sizing.CannotSize as reason:
                print('left out: case%04d, %s' % (cases[i]['index'], reason), flush=True)
                continue
            if not quiet:
                print('%s %d/%d case%04d %s' % (cases[i]['suite'], done, len(cases), cases[i]['index'],
                                                line_of(records[i])), file=sys.stderr, flush=True)
    return [record for record in records if record is not None]
