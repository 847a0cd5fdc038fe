#!/usr/bin/env python3
"""Report pages in a browser: every picture is drawn, nothing is complained of, nothing is asked of anybody.

usage: report_pages_test.py PROGRAM   (skips where Chromium is not installed)
"""
import html.parser
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
EXPERIMENT = str(ROOT / 'problems/published/kr270/experiment.yaml')
COMMANDS = {
    'calibrate': ['calibrate', EXPERIMENT, '--holdout=0.3', '--seed=1'],
    'diagnose': ['diagnose', EXPERIMENT, '--holdout=0.3', '--seed=1'],
    'plan': ['plan', EXPERIMENT, '--poses=6', '--pool=60'],
    'inspect': ['inspect', EXPERIMENT],
}
PROGRAM = ''
CHROMIUM = shutil.which('chromium')


class Figures(html.parser.HTMLParser):
    """Rows of the table of each figure; addresses that any element names."""

    def __init__(self, text):
        super().__init__()
        self.rows, self.addresses, self.inside = [], [], False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.inside = tag == 'figure' or (self.inside and tag != 'figure')
        if tag == 'figure':
            self.rows.append(0)
        if tag == 'tr' and self.inside:
            self.rows[-1] += 1
        self.addresses += [v for k, v in attrs if k in ('src', 'href') and v and not v.startswith('#')]

    def handle_endtag(self, tag):
        self.inside = self.inside and tag != 'figure'


def open_page(path):
    """The page's elements after its scripts have run, and what the console says."""
    with tempfile.TemporaryDirectory() as profile:
        run = subprocess.run(
            [CHROMIUM, '--headless=new', '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
             '--enable-logging=stderr', '--user-data-dir=' + profile, '--host-resolver-rules=MAP * ~NOTFOUND',
             '--window-size=1100,900', '--virtual-time-budget=60000', '--timeout=300000', '--dump-dom',
             path.as_uri()], capture_output=True, text=True, timeout=580)
    return run.stdout, re.findall(r'.*CONSOLE.*', run.stderr)


class ReportPages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.pages = {}
        for name, command in COMMANDS.items():
            out = pathlib.Path(cls.folder.name) / name
            subprocess.run([PROGRAM, *command, '--quiet', '--out=%s' % out], check=True, capture_output=True)
            cls.pages[name] = out / 'report.html'

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_every_picture_has_a_table_and_no_page_names_an_address(self):
        for name, path in self.pages.items():
            figures = Figures(path.read_text())
            self.assertTrue(figures.rows, name)
            self.assertTrue(all(rows > 1 for rows in figures.rows), (name, figures.rows))
            self.assertEqual(figures.addresses, [], name)
            self.assertLess(path.stat().st_size, 4 << 20, name)

    def test_every_picture_is_drawn_and_nothing_is_complained_of(self):
        if CHROMIUM is None:
            self.skipTest('chromium is not installed (tools/install-dependencies --tests)')
        if 'id="templates"' not in self.pages['calibrate'].read_text():
            self.skipTest('built without libjs-vega and libjs-three')
        for name, path in self.pages.items():
            # Everything unfolded: what is folded is drawn when it is opened.
            page = path.with_name('open.html')
            page.write_text(path.read_text().replace('<details>', '<details open>'))
            shown, said = open_page(page)
            self.assertEqual(said, [], name)
            self.assertIn('data-ready="yes"', shown, name)
            figures = shown.count('<figure class="picture">')
            self.assertGreater(figures, 0)
            self.assertIn('data-drawn="%d"' % figures, shown, name)
            places = re.findall(r'<div class="place"[^>]*>(.{0,40})', shown, re.S)
            self.assertEqual(len(places), figures)
            for place in places:
                self.assertRegex(place, r'^(<svg|<canvas|<div class="|<form)', name)


if __name__ == '__main__':
    PROGRAM = sys.argv.pop(1)
    unittest.main()
