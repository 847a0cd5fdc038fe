#!/usr/bin/env python3
"""Every number that a struct of options has is checked once, with its name.

A struct in a header of estimator/, problems/ or tools/ whose name ends with Options or Request and that has numbers (but
for seeds, which may be anything) is followed by `void CheckOptions(const IT&`, and some source hands each number to a
check under "IT.number"; options within options go to their own CheckOptions. What the checks refuse and that functions
ask them first: tests/estimator/options_test.cc.

Flags are read in tools/ by a command (Run…) and by what is named after them (…Flags): helpers get values. Standard
library only.

usage: options_test.py [ROOT]        check the tree (default: the one this file is in)
       options_test.py --self-test   prove that planted gaps are found
"""
import pathlib
import re
import sys
import tempfile

CHECKED = ('estimator', 'problems', 'tools')
CONSTANTS = {  # struct: why nobody but its own callers can set it
    'GaussNewtonOptions': 'constants of the refits, no door of the library accepts it',
    'AgreementOptions': 'made by Calibrate of the number of rows, no door of the library accepts it',
}
FLAG_READERS = {  # (file, function): why it reads one
    ('tools/command_line.cc', 'ParseCommandLine'): 'it is the parser that sets them',
    ('tools/problem_from_arguments.cc', 'PlausibleProblem'): 'its header promises that it applies the flags',
}
FUNCTION = re.compile(r'^(?!DEFINE_|DECLARE_)\w[^;=]*?\b(\w+)\((?!.*\);$)')
STRUCT = re.compile(r'^struct (\w+(?:Options|Request)) \{\n(.*?)^\};', re.DOTALL | re.MULTILINE)
NUMBERS = re.compile(r'^  (?:int|double|std::optional<double>|std::vector<double>|Vector3<double>|Eigen::VectorXd) ([^;]+);',
                     re.MULTILINE)
NESTED = re.compile(r'^  (\w+(?:Options|Masses)) (\w+)\b[^;(]*;', re.MULTILINE)
NAME = re.compile(r'(\w+)\s*(?:=\s*(?:\{[^}]*\}|[^,{]+))?(?:,\s*|$)')


def gaps(root):
    """Sentences on what is not checked, and the number of structs that are."""
    headers, sources = [], ''
    for folder in CHECKED:
        headers += sorted((root / folder).rglob('*.h'))
        sources += ''.join(path.read_text(encoding='utf-8') for path in sorted((root / folder).rglob('*.cc')))
    found, checked = [], 0
    for path in headers:
        text = path.read_text(encoding='utf-8')
        for struct, body in STRUCT.findall(text):
            body = re.sub(r'//[^\n]*', '', body)
            numbers = [name for members in NUMBERS.findall(body) for name in NAME.findall(members.strip())]
            nested = [(kind, name) for kind, name in NESTED.findall(body) if kind not in CONSTANTS]
            if struct in CONSTANTS or not (numbers or nested):
                continue
            checked += 1
            where = '%s: %s' % (path.relative_to(root).as_posix(), struct)
            if 'void CheckOptions(const %s& ' % struct not in text:
                found.append(where + ' has no CheckOptions next to it')
            for name in numbers:
                if '"%s.%s"' % (struct, name) not in sources:
                    found.append('%s: no check names its %s' % (where, name))
            for kind, name in nested:
                is_asked = 'CheckOptions(options.%s);' % name if kind.endswith('Options') else '"%s.%s.' % (struct, name)
                if is_asked not in sources:
                    found.append('%s: no check goes into its %s' % (where, name))
    return found, checked


def flags_read_by_helpers(root):
    """Sentences on helpers that read flags, and the number of reads that are where they should be."""
    found, good = [], 0
    for path in sorted((root / 'tools').rglob('*.cc')):
        name, function = path.relative_to(root).as_posix(), ''
        for number, line in enumerate(path.read_text(encoding='utf-8').split('\n'), 1):
            begun = FUNCTION.match(line)
            function = begun.group(1) if begun else function
            for flag in re.findall(r'\bFLAGS_(\w+)', line):
                if re.match('Run[A-Z]', function) or 'Flags' in function or (name, function) in FLAG_READERS:
                    good += 1
                else:
                    found.append('%s:%d: %s reads the flag --%s; give it the value' % (name, number, function, flag))
    return found, good


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / 'tools').mkdir()
        (root / 'tools/a.cc').write_text('DEFINE_string(a, "", "f(x)");\nint AFromFlags() { return FLAGS_a; }\n'
                                         'int Helper(const B& b,\n           int c) {\n  return FLAGS_a + FLAGS_b;\n}\n'
                                         'int RunA(const L& line) {\n  const B b(FLAGS_a);\n}\n', encoding='utf-8')
        found, good = flags_read_by_helpers(root)
        if [line.split(' reads')[0] for line in found] != ['tools/a.cc:5: Helper'] * 2 or good != 2:
            sys.exit('expected two flags in a helper and two at their place, found %s and %d' % (found, good))
    good = ('struct AOptions {\n  int a = 1, b = 2;  // m, c\n  std::vector<double> w = {1.0, 2.0};\n'
            '  std::uint64_t seed = 1;\n};\nvoid CheckOptions(const AOptions& options);\n'
            'struct BOptions {\n  AOptions inner;\n  bool flag = true;\n};\nvoid CheckOptions(const BOptions& options);\n'
            'struct COptions {\n  bool flag = true;\n};\n')
    source = 'CheckIn(r, o.a, "AOptions.a"); F("AOptions.b"); F("AOptions.w"); CheckOptions(options.inner);\n'
    planted = [(good, source, 0), (good, source.replace('AOptions.b', 'AOptions.c'), 1), (good, '', 4),
               (good.replace('void CheckOptions(const AOptions', 'void Check(const AOptions'), source, 1)]
    failures = 0
    for header, text, expected in planted:
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / 'estimator').mkdir()
            (root / 'estimator/a.h').write_text(header, encoding='utf-8')
            (root / 'estimator/a.cc').write_text(text, encoding='utf-8')
            found, checked = gaps(root)
        if len(found) != expected or checked != 2:
            failures += 1
            print('expected %d gaps in 2 structs, found %d: %s' % (expected, checked, found))
    return failures


def main():
    if sys.argv[1:] == ['--self-test']:
        sys.exit(1 if self_test() else 0)
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent
    found, checked = gaps(root)
    helpers, flags = flags_read_by_helpers(root)
    for sentence in found + helpers:
        print(sentence)
    if checked < 10 or flags < 50:
        sys.exit('only %d structs of options and %d flags were found' % (checked, flags))
    if found or helpers:
        sys.exit(1)
    print('%d structs of options are checked, %d flags are read by their commands' % (checked, flags))


if __name__ == '__main__':
    main()
