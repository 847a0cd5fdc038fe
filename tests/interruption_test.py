"""Ctrl-C: what works for long ends at once, writes nothing, and says what was found so far."""
import json
import pathlib
import re
import signal
import subprocess
import sys
import tempfile

PROGRAM = sys.argv[1]
PUBLISHED = pathlib.Path(__file__).resolve().parent.parent / 'problems' / 'published' / 'kr270'
PATIENCE_S = 120


def run(*arguments):
    subprocess.run([PROGRAM, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def interrupt_when(words, arguments):
    """Starts the program and interrupts it when its progress says any of `words`; None: it was done before that."""
    process = subprocess.Popen([PROGRAM, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    said = []
    for line in process.stderr:
        said.append(line)
        if any(each in line for each in words):
            process.send_signal(signal.SIGINT)
            break
    out, err = process.communicate(timeout=PATIENCE_S)
    if process.returncode == 0:
        return None
    assert process.returncode == -signal.SIGINT, (process.returncode, said, err)
    return out, ''.join(said) + err


def left_in(folder):
    return sorted(path.name for path in folder.iterdir()) if folder.exists() else []


def scene(folder, poses):
    """A robot whose joint A3 has a once-per-turn error, measured by a program that knows it; the copy does not."""
    rows = [row for row in (PUBLISHED / 'configurations.csv').read_text().splitlines() if not row.startswith('#')]
    header = rows[0].split(',')
    joints = [i for i, name in enumerate(header) if name.startswith('q') and name.endswith('_deg')]
    config = header.index('config')
    lines = [rows[0]]
    for k in range(poses):
        for row in rows[1:]:
            cells = row.split(',')
            cells[config] += f'_{k}'
            for i in joints:  # other poses near the published ones, the same in every run
                cells[i] = f'{float(cells[i]) + 9.0 * ((7 * k + 3 * i) % 11 - 5) / 5.0:.6f}'
            lines.append(','.join(cells))
    poses_file = folder / 'poses.csv'
    poses_file.write_text('\n'.join(lines) + '\n')
    robot = (PUBLISHED / 'robot.yaml').read_text()
    (folder / 'robot.yaml').write_text(robot)
    (folder / 'real.yaml').write_text(
        robot + '\neffects:\n  - {effect: joint_harmonic, joint: A3, order: 1, cos_urad: 300, sin_urad: -200}\n')
    run('calibrate', PUBLISHED / 'experiment.yaml', f'--out={folder / "truth"}', '--quiet')
    truth = json.loads((folder / 'truth' / 'estimate.json').read_text())
    stations = ', '.join(f'{name}: {{xyz_mm: {pose["xyz_mm"]}, rotvec_mrad: {pose["rotvec_mrad"]}}}'
                         for name, pose in truth['stations'].items())
    markers = ', '.join(f'{name}: {{xyz_mm: {point["xyz_mm"]}}}' for name, point in truth['markers'].items())
    experiment = folder / 'truth.yaml'
    experiment.write_text('schema: sagitta/experiment/1\nrobot: real.yaml\nmeasurements: [poses.csv]\n'
                          f'stations: {{{stations}}}\nmarkers: {{{markers}}}\nnoise: {{sigma_mm: 0.05}}\n')
    run('simulate', experiment, f'--truth={experiment}', f'--out={folder / "measured.csv"}', '--sigma_mm=0.05')


def test_diagnose_says_what_was_found_so_far():
    for poses in (80, 120, 160, 240, 320, 480, 960, 1920):  # more of them where the program is done before it is interrupted
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            scene(folder, poses)
            out = folder / 'out'
            ended = interrupt_when(['fitting the extended model', 'alternatives and halves'],
                                   ['diagnose', folder / 'robot.yaml', folder / 'measured.csv', '--sigma_mm=0.05',
                                    f'--out={out}'])
            if ended is None:
                continue
            stdout, stderr = ended
            assert 'found so far' in stderr and 'joint_harmonic, A3' in stderr, stderr
            assert 'interrupted; no result is written' in stderr, stderr
            assert left_in(out) == [] and 'Verdict' not in stdout
            return
    raise AssertionError('the diagnosis was always done before it could be interrupted')


def test_calibrate_writes_nothing():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / 'long.yaml').write_text(
            'schema: sagitta/experiment/1\n'
            f'robot: {PUBLISHED / "robot.yaml"}\nmeasurements: [{PUBLISHED / "geometric.csv"}]\n'
            'noise: {sigma_mm: 0.1}\ncovariance: bootstrap\nbootstrap: {kind: parametric, replicates: 100000}\n')
        out = folder / 'out'
        ended = interrupt_when(['bootstrap'], ['calibrate', folder / 'long.yaml', f'--out={out}'])
        assert ended is not None
        assert 'phase ' in ended[1], ended[1]
        assert 'interrupted; no result is written' in ended[1], ended[1]
        assert left_in(out) == []


def many_rows(folder, header, names):
    """The published poses over and over, as rows of `header` that begin with `names`."""
    rows = [row for row in (PUBLISHED / 'configurations.csv').read_text().splitlines() if not row.startswith('#')]
    joints = [i for i, name in enumerate(rows[0].split(',')) if name.startswith('q') and name.endswith('_deg')]
    file = folder / 'many.csv'
    with open(file, 'w', encoding='utf-8') as out:
        out.write(header + ',' + ','.join(rows[0].split(',')[i] for i in joints) + '\n')
        for k in range(400000):
            cells = rows[1 + k % (len(rows) - 1)].split(',')
            out.write(names % k + ',' + ','.join(cells[i] for i in joints) + '\n')
    return file


def test_predict_and_compensate_say_how_far_they_are():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run('calibrate', PUBLISHED / 'experiment.yaml', f'--out={folder / "truth"}', '--quiet')
        estimate = folder / 'truth' / 'estimate.json'
        for command, words, rows in (
                ('predict', 'phase 2 of 3: predicting', many_rows(folder, 'config,marker,station', 'C%d,P1,S1')),
                ('compensate', 'phase 1 of 2: correcting', None)):
            rows = rows or many_rows(folder, 'target', 'T%d')
            out = folder / f'{command}.csv'
            ended = interrupt_when([words], [command, estimate, rows, f'--out={out}'])
            assert ended is not None, command
            assert 'interrupted; no result is written' in ended[1], ended[1]
            assert not out.exists() and len(left_in(folder)) == 2, left_in(folder)


def test_long_tables_say_how_far_they_are():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        robot, rows = PUBLISHED / 'robot.yaml', folder / 'rows.csv'
        run('calibrate', PUBLISHED / 'experiment.yaml', f'--out={folder / "truth"}', '--quiet')
        estimate = folder / 'truth' / 'estimate.json'
        simulation = ['simulate', robot, many_rows(folder, 'config,marker,station', 'C%d,P1,S1'), f'--truth={estimate}',
                      f'--out={rows}']
        for command, words, arguments in (('simulate', 'phase 2 of 3: simulating', simulation),
                                          ('validate', 'phase 2 of 3: comparing 400000', ['validate', estimate, rows]),
                                          ('import', 'phase 2 of 4: interpreting', ['import', robot, rows])):
            if command != 'simulate':
                if not rows.exists():
                    run(*simulation, '--quiet')
                arguments.append(f'--out={folder / "out"}')
            before = left_in(folder)
            ended = interrupt_when([words], arguments)
            assert ended is not None, command
            assert 'interrupted; no result is written' in ended[1], ended[1]
            assert left_in(folder) == before, left_in(folder)


def test_compare_says_which_methods_are_done():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        ended = interrupt_when(['iteration'], ['compare', *many_readings(folder), '--sigma_mm=0.1',
                                             '--methods=joint,two-step-literal', f'--out={folder / "out"}'])
        assert ended is not None
        said = ended[1]
        assert 'found so far' in said and 'Methods on the same data' in said and '  joint ' in said, said
        assert 'it was at phase 3 of 3' in said and 'interrupted; no result is written' in said, said
        assert left_in(folder / 'out') == []


def many_readings(folder):
    """Thousands of rows of the published robot: each step of a method is long enough to be seen."""
    rows = [row for row in (PUBLISHED / 'geometric.csv').read_text().splitlines() if not row.startswith('#')]
    config, repeats = rows[0].split(',').index('config'), 150
    lines = [rows[0]]
    for k in range(repeats):
        for row in rows[1:]:
            cells = row.split(',')
            cells[config] += f'_{k}'
            lines.append(','.join(cells))
    (folder / 'rows.csv').write_text('\n'.join(lines) + '\n')
    return PUBLISHED / 'robot.yaml', folder / 'rows.csv'


def test_plan_says_what_was_found_so_far():
    with tempfile.TemporaryDirectory() as name:
        out = pathlib.Path(name) / 'out'
        for words in ('moving', 'accuracy of'):
            ended = interrupt_when([words], ['plan', PUBLISHED / 'experiment.yaml', '--poses=60', '--pool=8000',
                                             '--sigma_mm=0.1', f'--out={out}'])
            assert ended is not None
            assert 'found so far:\n  60 poses: ' in ended[1] and 'it was at phase ' in ended[1], ended[1]
            assert 'interrupted; no result is written' in ended[1], ended[1]
            assert not out.exists() and 'Written' not in ended[0]


def test_coverage_keeps_its_trials_and_says_so():
    with tempfile.TemporaryDirectory() as name:
        out = pathlib.Path(name) / 'out'
        ended = interrupt_when(['trials: '], ['coverage', PUBLISHED / 'experiment.yaml', '--trials=100000',
                                              f'--out={out}'])
        assert ended is not None
        said = re.search(r'(\d+) of 100000 trials are done; their 95 % intervals held ([\d.]+) %', ended[1])
        assert said and int(said[1]) > 0 and 80.0 < float(said[2]) <= 100.0, ended[1]
        assert 'the same command goes on' in ended[1] and 'phase 2 of 2: trials: ' in ended[1], ended[1]
        assert left_in(out) == ['coverage.state.jsonl']


def test_reproduce_says_which_tables_are_done():
    with tempfile.TemporaryDirectory() as name:
        out = pathlib.Path(name) / 'out'
        ended = interrupt_when([' trials'], ['reproduce', '--trials=20000', f'--out={out}'])
        assert ended is not None
        assert 'found so far' in ended[1] and '002-V ' in ended[1] and '002-VII ' not in ended[1], ended[1]
        assert 'computing 002-VI: ' in ended[1] and 'interrupted; no result is written' in ended[1], ended[1]
        assert not out.exists()


if __name__ == '__main__':
    test_compare_says_which_methods_are_done()
    test_plan_says_what_was_found_so_far()
    test_coverage_keeps_its_trials_and_says_so()
    test_reproduce_says_which_tables_are_done()
    test_calibrate_writes_nothing()
    test_predict_and_compensate_say_how_far_they_are()
    test_long_tables_say_how_far_they_are()
    test_diagnose_says_what_was_found_so_far()
    print('ok')
