#!/usr/bin/env python3
"""Keeps sentences in their place: in estimator/ they stand in estimator/report/, one file per subject (ROOM_…words.cc);
those of pages and of the terminal in tools/report/. Elsewhere are numbers and typed reasons.

A statement outside these folders may hold fewer than 10 words of text in estimator/, 14 in the commands of tools/ (the
summary of a command is 13); keys and column names (literals without a blank) are none. Words of input errors and of failures, with their hints, are free: they arise where the input is found to be
wrong (throw, Fail…, CHECK, a variable named hint), and so is what a developer reads in the log (VLOG). In tools/ so are flags (DEFINE_…), what goes to std::cerr, and the files that are help themselves;
tools/reproduce/ is a study with its words next to its numbers.
Standard library only.

usage: prose_test.py [ROOT]        check the tree (default: the one this file is in)
       prose_test.py --self-test   prove that planted violations are found
       prose_test.py --list        every statement outside the folder that is a sentence, with its words
"""
import pathlib
import re
import sys

# Folder: where its sentences stand, words of a statement from which it is a sentence.
PLACES = {'estimator': ('estimator/report', 10), 'tools': ('tools/report', 14)}
FREE = ('tools/reproduce/', 'tools/examples/', 'tools/main.cc', 'tools/shell_pages.cc')
ERROR = re.compile(r'\bthrow\b|\bFail\w*\(|\bfail\(|\bInputError\b|\bFailure\b|\bD?CHECK|\bVLOG\(|\bDEFINE_|\bstd::cerr\b|\b(k?H|h)int\b')
LITERAL = re.compile(r'"(?:[^"\\\n]|\\.)*"')
SKIPPED = re.compile(r'//[^\n]*|/\*.*?\*/|^[ \t]*#include[^\n]*|\'(?:\\.|[^\'\\\n])\'', re.DOTALL | re.MULTILINE)
WORD = re.compile(r'[A-Za-z]{2,}')


def sentences(text, most=12):
    """Line and number of words of every statement with `most` words or more."""
    literals = []  # start and number of words
    code = list(text)  # without literals and comments, place by place
    position = 0
    while position < len(text):
        skipped = SKIPPED.match(text, position)
        literal = LITERAL.match(text, position)
        end = (skipped or literal).end() if skipped or literal else position + 1
        if literal and not skipped and ' ' in literal.group():
            literals.append((position, len(WORD.findall(literal.group()))))
        if skipped or literal:
            code[position:end] = ['_'] * (end - position)
        position = end
    code = ''.join(code)
    statements = {}
    for start, words in literals:
        begin = max(code.rfind(end, 0, start) for end in (';', '{\n', '}\n'))
        statements.setdefault(begin, [start, 0])[1] += words
    for begin, (start, words) in statements.items():
        end = code.find(';', start)
        if words >= most and not ERROR.search(code[begin + 1:end]):
            yield text.count('\n', 0, start) + 1, words


def files(root):
    for folder, (place, most) in PLACES.items():
        for path in sorted((root / folder).rglob('*')):
            name = path.relative_to(root).as_posix()
            if path.suffix in ('.cc', '.h') and not name.startswith((place + '/',) + FREE):
                yield name, place, list(sentences(path.read_text(encoding='utf-8'), most))


def self_test():
    twelve = 'one two three four five six seven eight nine ten eleven twelve'
    planted = [
        ('void F() {\n  Say("%s");\n}\n' % twelve, [2]),
        ('void F() {\n  Say("%s");\n}\n' % twelve.replace(' twelve', ''), []),
        ('void F() {\n  Say("one two three four five six"\n      " seven eight nine" + x + " ten eleven twelve");\n}\n', [2]),
        ('void F() {\n  Say("one two three four five six");\n  Say("seven eight nine ten eleven twelve");\n}\n', []),
        ('void F() {\n  throw InputError({}, "%s");\n}\n' % twelve, []),
        ('void F() {\n  const char* kHint = "%s";\n}\n' % twelve, []),
        ('void F() {\n  root.Get("the schema").Fail("%s");\n}\n' % twelve, []),
        ('void F() {\n  Say("one two; three four five six seven " "eight nine ten eleven twelve");\n}\n', [2]),
        ('void F() {\n  Say({%s});\n}\n' % ', '.join('"%s_mm"' % word for word in twelve.split()), []),
        ('DEFINE_string(x, "", "%s");\n' % twelve, []),
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
    for path, place, found in files(root):
        looked_at += 1
        for line, words in found:
            failures += 1
            print('%s:%d: a sentence of %d words' % (path, line, words)
                  + ('' if is_list else ': put it into a file of %s/' % place))
    if not failures:
        print('%d files, every sentence is in its folder' % looked_at)
    return 1 if failures and not is_list or looked_at < 100 else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
