#!/usr/bin/env python3
"""Every function, struct, class and enum that a user of the library gets to see says what it is.

Looks at <sagitta/sagitta.h> and all that it includes, directly or not (cmake/Install.cmake installs the same). A
declaration at namespace scope needs a comment above it; several in a row share one, the first of a header may be what
the header's own comment is about, and what fits on its line may have it behind. Standard library only.

usage: docstrings_test.py [ROOT]        check the tree (default: the one this file is in)
       docstrings_test.py --self-test   prove that planted violations are found
"""
import pathlib
import re
import sys

FRONT_DOOR = 'estimator/sagitta.h'
# In column 0, where namespaces are not indented; a name with :: is defined here and declared above.
DECLARATION = re.compile(r'(?=\S)(?:(?:struct|class|enum class) \w+|(?:inline |constexpr |const |static )*[\w:<>,&* ]+[ &*]\w+\()')
FORWARD = re.compile(r'(?:struct|class|enum class) [\w:]+;')
OTHER = re.compile(r'(?:namespace|using|extern|static_assert|template|friend|return|public|private|#|SAGITTA_)')


def closure(root):
    """The front door and every header of the tree behind it, in the order they are met."""
    found = []

    def follow(header):
        if header in found:
            return
        found.append(header)
        for next_one in re.findall(r'^#include "([^"]+)"', (root / header).read_text(encoding='utf-8'), re.MULTILINE):
            follow(next_one)

    follow(FRONT_DOOR)
    return found


def has_comment(lines, i, is_first):
    """Whether the declaration in line i is commented, or shares the comment of those right above it."""
    if '//' in lines[i]:
        return True
    for line in reversed(lines[:i]):
        if line.startswith('//'):
            return True
        if not line.strip() or line.startswith('}'):
            break
    return is_first and lines[0].startswith('//')


def undocumented(text):
    """Lines and declarations without a word of what they are."""
    lines = text.split('\n')
    is_first = True
    for i, line in enumerate(lines):
        if OTHER.match(line) or FORWARD.match(line) or not DECLARATION.match(line):
            continue
        if i > 0 and lines[i - 1] == 'template <>':  # its template says what it is
            continue
        if re.match(r'[^(]*::\w+\(', line) or re.match(r'[^(]*\w::operator', line):
            continue
        if not has_comment(lines, i, is_first):
            yield i + 1, line
        is_first = False


def self_test():
    head = '// What the header is about.\n#pragma once\n\nnamespace sagitta {\n\n'
    planted = [
        (head + 'struct First {\n  int a = 0;\n};\n\nstruct Second {\n  int b = 0;\n};\n', ['struct Second {']),
        (head + 'struct First {};\n\n// One and the other.\nint One();\nint Other(double x);\n', []),
        (head + 'struct First {};\n\nstd::vector<int> All(const First& of);\n', ['std::vector<int> All(const First& of);']),
        (head + '// An enum.\nenum class Kind { kA, kB };\n\nenum class Other { kC };\n', ['enum class Other { kC };']),
        (head + '// A.\nstruct A {};\nstruct B {};\n', ['struct B {};'][:0]),
        (head + 'class Forward;\n\n// A template.\ntemplate <typename T>\nT Twice(const T& x);\n', []),
        (head + 'struct First {};\n\ntemplate <typename T>\nT Twice(const T& x);\n', ['T Twice(const T& x);']),
        (head + '// A template.\ntemplate <typename T>\nstruct Of;\n\ntemplate <>\nstruct Of<int> {};\n', []),
        (head + 'int First();\n\ninline int Next(int i) { return i + 1; }  // the one after\n', []),
        ('#pragma once\nnamespace sagitta {\nint First();\n', ['int First();']),
    ]
    failures = 0
    for text, expected in planted:
        found = [line for _, line in undocumented(text)]
        if found != expected:
            print('self-test: found %s instead of %s' % (found, expected))
            failures += 1
    print('%d planted headers, %d failures' % (len(planted), failures))
    return 1 if failures else 0


def main(arguments):
    if arguments == ['--self-test']:
        return self_test()
    root = pathlib.Path(arguments[0] if arguments else __file__).resolve()
    root = root if arguments else root.parents[1]
    headers = closure(root)
    findings = ['%s:%d: says nothing of itself: %s' % (header, number, line)
                for header in headers for number, line in undocumented((root / header).read_text(encoding='utf-8'))]
    print('\n'.join(findings) if findings else 'every declaration of %d public headers is documented' % len(headers))
    return 1 if findings or len(headers) < 40 else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
