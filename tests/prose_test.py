#!/usr/bin/env python3
"""Keeps sentences in their place: in estimator/ they stand in files named *_words.cc, one per subject, beside the numbers
that they speak of; pages and the terminal are tools/'s matter.

A statement outside such a file may hold fewer than 12 words of text. Words of errors are free: they arise where the
input is found to be wrong (throw, Fail…, CHECK). LEFT lists what older files still hold; it may shrink only.
Standard library only.

usage: prose_test.py [ROOT]        check the tree (default: the one this file is in)
       prose_test.py --self-test   prove that planted violations are found
       prose_test.py --list        the table LEFT as it would be now
"""
import pathlib
import re
import sys

MOST_WORDS = 12  # of a statement: more is a sentence
LEFT = {
'estimator/baselines/compare_methods.cc': 12,
    'estimator/baselines/damped_step.cc': 13,
    'estimator/baselines/differencing.cc': 51,
    'estimator/baselines/full_pose.cc': 61,
    'estimator/baselines/two_step.cc': 46,
    'estimator/calibration/joint_estimator.cc': 47,
    'estimator/calibration/judge.cc': 63,
    'estimator/calibration/load_remedy.cc': 92,
    'estimator/calibration/unit_guess.cc': 63,
    'estimator/changes/changes.cc': 12,
    'estimator/changes/comparison.cc': 13,
    'estimator/compensation/compensate.cc': 69,
    'estimator/compensation/joint_solutions.cc': 59,
    'estimator/diagnosis/candidates.cc': 12,
    'estimator/diagnosis/cautions.cc': 351,
    'estimator/inspection/data_lint.cc': 361,
    'estimator/inspection/inspect.cc': 34,
    'estimator/inspection/load_lint.cc': 67,
    'estimator/inspection/reading_lint.cc': 50,
    'estimator/inspection/readings.cc': 237,
    'estimator/inspection/row_lint.cc': 14,
    'estimator/inspection/torque_lint.cc': 76,
    'estimator/inspection/wild_rows.cc': 47,
    'estimator/intervals/bootstrap.cc': 12,
    'estimator/intervals/profile.cc': 30,
    'estimator/least_squares/minimize.cc': 13,
    'estimator/least_squares/spring_tie_cost.cc': 50,
    'estimator/noise/robot_scatter.cc': 25,
    'estimator/planning/feasible.cc': 14,
    'estimator/planning/plan.cc': 154,
    'estimator/planning/scene.cc': 84,
    'estimator/predict.cc': 20,
    'estimator/predicted_rows.cc': 96,
    'estimator/results/diagnosis_json.cc': 57,
    'estimator/results/estimate_reader.cc': 40,
    'estimator/results/noise_json.cc': 17,
    'estimator/results/plan_json.cc': 151,
    'estimator/results/program_compensation.cc': 78,
    'estimator/results/torques_json.cc': 12,
    'estimator/results/trust_json.cc': 12,
    'estimator/simulate.cc': 19,
    'estimator/validation/suspects.cc': 14,
    'estimator/validation/trust.cc': 131,
}
ERROR = re.compile(r'\bthrow\b|\bFail\w*\(|\bfail\(|\bInputError\b|\bFailure\b|\bD?CHECK')
LITERAL = re.compile(r'"(?:[^"\\\n]|\\.)*"')
SKIPPED = re.compile(r'//[^\n]*|/\*.*?\*/|^[ \t]*#include[^\n]*|\'(?:\\.|[^\'\\\n])\'', re.DOTALL | re.MULTILINE)
WORD = re.compile(r'[A-Za-z]{2,}')


def sentences(text):
    """Line and number of words of every statement with MOST_WORDS words or more."""
    literals = []  # start and number of words
    position = 0
    while position < len(text):
        skipped = SKIPPED.match(text, position)
        literal = LITERAL.match(text, position)
        if literal and not skipped:
            literals.append((position, len(WORD.findall(literal.group()))))
        position = (skipped or literal).end() if skipped or literal else position + 1
    statements = {}
    for start, words in literals:
        begin = max(text.rfind(end, 0, start) for end in (';', '{\n', '}\n'))
        statements.setdefault(begin, [start, 0])[1] += words
    for begin, (start, words) in statements.items():
        if words >= MOST_WORDS and not ERROR.search(text[begin + 1:start]):
            yield text.count('\n', 0, start) + 1, words


def files(root):
    for path in sorted((root / 'estimator').rglob('*')):
        if path.suffix in ('.cc', '.h') and not path.stem.endswith('_words'):
            yield path.relative_to(root).as_posix(), list(sentences(path.read_text(encoding='utf-8')))


def self_test():
    twelve = 'one two three four five six seven eight nine ten eleven twelve'
    planted = [
        ('void F() {\n  Say("%s");\n}\n' % twelve, [2]),
        ('void F() {\n  Say("%s");\n}\n' % twelve.replace(' twelve', ''), []),
        ('void F() {\n  Say("one two three four five six"\n      " seven eight nine" + x + " ten eleven twelve");\n}\n', [2]),
        ('void F() {\n  Say("one two three four five six");\n  Say("seven eight nine ten eleven twelve");\n}\n', []),
        ('void F() {\n  throw InputError({}, "%s");\n}\n' % twelve, []),
        ('// "%s"\nint x;\n' % twelve, []),
        ("char q = '\"';\nint x;  // %s\nchar r = '\"';\n" % twelve, []),
    ]
    failures = 0
    for text, expected in planted:
        found = [line for line, _ in sentences(text)]
        if found != expected:
            print('self-test: found %s instead of %s in %r' % (found, expected, text))
            failures += 1
    print('%d planted statements, %d failures' % (len(planted), failures))
    return 1 if failures else 0


def main(arguments):
    if arguments == ['--self-test']:
        return self_test()
    is_list = arguments == ['--list']
    root = pathlib.Path(arguments[0]).resolve() if arguments and not is_list else pathlib.Path(__file__).resolve().parents[1]
    failures = looked_at = 0
    for path, found in files(root):
        looked_at += 1
        words = sum(count for _, count in found)
        if is_list and words:
            print("    '%s': %d," % (path, words))
        elif words > LEFT.get(path, 0):
            failures += 1
            lines = ', '.join(str(line) for line, _ in found)
            print('%s: %d words of sentences, %d may stand there (lines %s): put them into a file *_words.cc of its room'
                  % (path, words, LEFT.get(path, 0), lines))
    if not is_list and not failures:
        print('sentences are in their place; %d words are left in %d older files' % (sum(LEFT.values()), len(LEFT)))
    return 1 if failures or looked_at < 100 else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
