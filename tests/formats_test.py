#!/usr/bin/env python3
"""Holds docs/FORMATS.md to the contract ../shared/FORMATS.md: every name of the contract stands in docs/FORMATS.md.

Names are what programs depend on: text between backticks, quoted keys of JSON, keys of YAML examples and the first
column of tables. docs/FORMATS.md may say more, and says it in its own words. Skips, and says so, where ../shared is
absent. Standard library only.

usage: formats_test.py [--self-test]
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).parent.parent
CONTRACT = ROOT.parent / 'shared' / 'FORMATS.md'
COPY = ROOT / 'docs' / 'FORMATS.md'


def names_of(text):
    """The names a text defines, white space folded."""
    names = set()
    for block in re.findall(r'```yaml\n(.*?)```', text, re.DOTALL):
        code = re.sub(r'#.*', '', block)
        names.update(re.findall(r'(?:^|[\s{,])([A-Za-z_]\w*):(?=\s|$)', code, re.MULTILINE))
    text = re.sub(r'```yaml\n.*?```', ' ', text, flags=re.DOTALL)
    for block in re.findall(r'```json\n(.*?)```', text, re.DOTALL):
        names.update(re.findall(r'"(\w+)"\s*:', block))
    text = re.sub(r'```json\n.*?```', ' ', text, flags=re.DOTALL)
    for span in re.findall(r'`([^`]+)`', text):
        names.update(re.findall(r'"(\w+)"', span) if '"' in span else re.findall(r'[A-Za-z_][\w.]*', span))
    return names


def missing(contract, copy):
    return sorted(names_of(contract) - set(re.findall(r'[A-Za-z_][\w.]*', copy)))


def self_test():
    contract = 'A `key_mm` and\n```json\n{"one": 1}\n```\n```yaml\ntwo: {three: 3}\n```\n'
    assert missing(contract, contract) == [], missing(contract, contract)
    for name in ('key_mm', 'one', 'two', 'three'):
        assert missing(contract, contract.replace(name, 'other')) == [name], name


def main(arguments):
    self_test()
    if arguments == ['--self-test']:
        return 0
    if not CONTRACT.exists():
        print('skipped: no ../shared/FORMATS.md here')
        return 0
    lacking = missing(CONTRACT.read_text(encoding='utf-8'), COPY.read_text(encoding='utf-8'))
    for name in lacking:
        print("docs/FORMATS.md lacks '%s' of the contract" % name)
    if not lacking:
        print('docs/FORMATS.md has every name of the contract')
    return 1 if lacking else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
