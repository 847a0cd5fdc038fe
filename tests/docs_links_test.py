#!/usr/bin/env python3
"""Links of the pages lead somewhere: the file is in the checkout, the heading is on its page, the picture is shown by a
page, and the sources that the maps name are there. Addresses elsewhere are not asked for. Standard library only.
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FENCE = re.compile(r'^```.*?^```$', re.MULTILINE | re.DOTALL)
LINK = re.compile(r'!?\[[^\]]*\]\(([^)\s]+)\)')
CODE = re.compile(r'`[^`\n]*`')
SOURCE = re.compile(r'`((?:models|problems|estimator|tools|tests|python|cmake|docs)/[\w./*-]+)`')
MAPS = ('ARCHITECTURE.md', 'docs/WHERE.md', 'docs/THEORY.md', 'docs/DECISIONS.md')
ELSEWHERE = re.compile(r'^[a-z]+:')


def pages():
    git = subprocess.run(['git', 'ls-files', '--cached', '--others', '--exclude-standard', '*.md'], cwd=ROOT,
                         capture_output=True, text=True, check=False)
    names = git.stdout.split() or [str(p.relative_to(ROOT)) for p in ROOT.rglob('*.md') if 'build' not in p.parts]
    return [ROOT / name for name in sorted(names)]


def prose(page):
    return FENCE.sub('', page.read_text(encoding='utf-8'))


def anchors(page):
    """As the pages are shown: lower case, no punctuation, blanks as hyphens, repeated ones numbered."""
    found = {}
    for heading in re.findall(r'^#+ +(.*)$', prose(page), re.MULTILINE):
        text = LINK.sub(lambda m: m.group(0)[1:m.group(0).index(']')], heading)
        slug = re.sub(r'[^\w\- ]', '', text.lower()).replace(' ', '-')
        found[slug] = found.get(slug, -1) + 1
        yield slug if found[slug] == 0 else '%s-%d' % (slug, found[slug])


def defects(page):
    name = page.relative_to(ROOT)
    for target in LINK.findall(CODE.sub('', prose(page))):
        if ELSEWHERE.match(target):
            if not re.match(r'(https?://[^\s/]+\.[a-z]+(/|$)|mailto:)', target):
                yield '%s: %s is no address' % (name, target)
            continue
        path, _, anchor = target.partition('#')
        to = (page.parent / path).resolve() if path else page
        if not to.exists() or ROOT not in to.parents and to != ROOT:
            yield '%s: %s is not there' % (name, target)
        elif anchor and (to.suffix != '.md' or anchor not in anchors(to)):
            yield '%s: %s has no heading #%s' % (name, path or name, anchor)


def unshown_pictures():
    shown = {(page.parent / target).resolve() for page in pages() for target in LINK.findall(prose(page))
             if not ELSEWHERE.match(target)}
    for picture in sorted((ROOT / 'docs' / 'pictures').glob('*.svg')):
        if picture not in shown:
            yield 'docs/pictures/%s is on no page' % picture.name


def absent_sources():
    for name in MAPS:
        for source in SOURCE.findall((ROOT / name).read_text(encoding='utf-8')):
            if not list(ROOT.glob(source)) and not list(ROOT.glob(source + '.*')):
                yield '%s: %s is not there' % (name, source)


def main():
    checked = pages()
    found = [defect for page in checked for defect in defects(page)] + list(unshown_pictures())
    found += absent_sources()
    print('\n'.join(found) if found else 'the links of %d pages lead somewhere' % len(checked))
    return 1 if found or not checked else 0


if __name__ == '__main__':
    sys.exit(main())
