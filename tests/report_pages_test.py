#!/usr/bin/env python3
"""Report pages in a browser: every picture is drawn, nothing is complained of, nothing is asked of anybody.

usage: report_pages_test.py PROGRAM   (skips where Chromium is not installed)
"""
import html.parser
import json
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
EXPERIMENT = str(ROOT / 'problems/published/kr270/experiment.yaml')
COMMANDS = {
    'calibrate': ['calibrate', EXPERIMENT, '--holdout=0.3', '--seed=1'],
    'diagnose': ['diagnose', EXPERIMENT, '--holdout=0.3', '--seed=1'],
    'plan': ['plan', EXPERIMENT, '--poses=6', '--pool=60'],
    'inspect': ['inspect', EXPERIMENT],
    'few': ['calibrate', EXPERIMENT, '--holdout=0.1', '--seed=1'],
}
ROWS = 10008       # of the page whose loading is timed
MOST_SECONDS = 2.0  # of one core, from the address to the last picture
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


class Browser:
    """Chromium by its own protocol over a pipe: numbers that a dump of the page does not have."""

    def __init__(self, profile):
        to_browser, self.write_end = os.pipe()
        self.read_end, from_browser = os.pipe()

        def connect():  # the protocol's descriptors are 3 and 4
            ours = [os.dup(to_browser), os.dup(from_browser)]
            for source, target in zip(ours, (3, 4)):
                os.dup2(source, target)
                os.set_inheritable(target, True)

        self.process = subprocess.Popen(
            [CHROMIUM, '--headless=new', '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
             '--user-data-dir=' + profile, '--host-resolver-rules=MAP * ~NOTFOUND', '--remote-debugging-pipe',
             'about:blank'], preexec_fn=connect, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.unread, self.calls, self.session = b'', 0, None
        target = self.call('Target.createTarget', url='about:blank')['targetId']
        self.session = self.call('Target.attachToTarget', targetId=target, flatten=True)['sessionId']

    def call(self, method, on_browser=False, **parameters):
        self.calls += 1
        message = {'id': self.calls, 'method': method, 'params': parameters}
        if self.session and not on_browser:
            message['sessionId'] = self.session
        os.write(self.write_end, json.dumps(message).encode() + b'\0')
        while True:
            while b'\0' not in self.unread:
                self.unread += os.read(self.read_end, 1 << 16)
            text, self.unread = self.unread.split(b'\0', 1)
            answer = json.loads(text)
            if answer.get('id') == self.calls:
                return answer.get('result', {})

    def value(self, expression):
        return self.call('Runtime.evaluate', expression=expression, returnByValue=True)['result'].get('value')

    def seconds_of_pages(self):
        processes = self.call('SystemInfo.getProcessInfo', on_browser=True)['processInfo']
        return sum(one['cpuTime'] for one in processes if one['type'] == 'renderer')

    def load(self, path):
        """Seconds of the processor that the page takes, and of the clock, until its last picture is drawn."""
        before = self.seconds_of_pages()
        self.call('Page.navigate', url=path.as_uri())
        for _ in range(3000):
            drawn = self.value("location.protocol === 'file:' && performance.getEntriesByName('drawn').length > 0")
            if drawn:
                break
            time.sleep(0.1)
        clock = self.value("performance.getEntriesByName('drawn')[0].startTime") / 1e3
        return self.seconds_of_pages() - before, clock

    def close(self):
        self.call('Browser.close', on_browser=True)
        self.process.wait(timeout=60)
        os.close(self.write_end)
        os.close(self.read_end)


def ten_thousand_rows(folder):
    """The page of a calibration of ROWS simulated rows."""
    random.seed(5)
    ranges = [(-150, 150), (-140, -10), (-100, 140), (-170, 170), (-110, 110), (-170, 170)]
    lines = ['config,marker,station,' + ','.join('q%d_deg' % (j + 1) for j in range(6))]
    for pose in range(ROWS // 6):
        values = ','.join('%.3f' % random.uniform(*ends) for ends in ranges)
        lines += ['C%d,%s,%s,%s' % (pose, marker, station, values)
                  for station in ('S1', 'S2') for marker in ('P1', 'P2', 'P3')]
    (folder / 'poses.csv').write_text('\n'.join(lines) + '\n')
    robot = str(ROOT / 'problems/published/kr270/robot.yaml')

    def run(*words):
        subprocess.run([PROGRAM, *words, '--quiet'], check=True, capture_output=True)

    run('calibrate', EXPERIMENT, '--out=%s' % (folder / 'truth'))
    run('simulate', robot, str(folder / 'poses.csv'), '--truth=%s' % (folder / 'truth/estimate.json'),
        '--sigma_mm=0.05', '--out=%s' % (folder / 'rows.csv'))
    run('calibrate', robot, str(folder / 'rows.csv'), '--sigma_mm=0.05', '--out=%s' % (folder / 'many'))
    return folder / 'many/report.html'


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

    def test_without_scripts_every_table_stands_open(self):
        for name, path in self.pages.items():
            text = re.sub(r'<script.*?</script>', '', path.read_text(), flags=re.S)
            self.assertEqual(text.count('<details open><summary>Table'), text.count('<figure class="picture">'), name)

    def test_ten_thousand_rows_load_quickly(self):
        page = ten_thousand_rows(pathlib.Path(self.folder.name))
        self.assertLess(page.stat().st_size, 4 << 20)
        if CHROMIUM is None:
            self.skipTest('chromium is not installed (tools/install-dependencies --tests)')
        if 'id="templates"' not in page.read_text():
            self.skipTest('built without libjs-vega and libjs-three')
        with tempfile.TemporaryDirectory() as profile:
            browser = Browser(profile)
            loads = [browser.load(page) for _ in range(3)]
            browser.close()
        print('%.1f MB, %d rows: %s' % (page.stat().st_size / 1e6, ROWS, ', '.join(
            '%.2f s of the processor, %.2f s by the clock' % load for load in loads)))
        # Not by the clock: other work on the machine is no matter of the page.
        self.assertLess(min(processor for processor, _ in loads), MOST_SECONDS)

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

    def test_few_held_out_points_lie_on_top_of_the_fitted(self):
        if CHROMIUM is None:
            self.skipTest('chromium is not installed (tools/install-dependencies --tests)')
        if 'id="templates"' not in self.pages['few'].read_text():
            self.skipTest('built without libjs-vega and libjs-three')
        shown, _ = open_page(self.pages['few'])
        points = re.search(r'role-mark points".*?</g>', shown, re.S).group(0)
        drawn = re.findall(r'fill="([^"]*)" fill-opacity="([^"]*)"', points)
        self.assertEqual(len(drawn), 54)
        fitted, held_out = ('#0072b2', '0.6'), ('#d55e00', '1')  # 2 of 18 configurations, three markers each
        self.assertEqual(drawn, [fitted] * 48 + [held_out] * 6)

    def test_suspects_and_directions_are_lists(self):
        for name, path in self.pages.items():
            text = re.sub(r'<script.*?</script>', '', path.read_text(), flags=re.S)
            self.assertNotIn('<p>- ', text, name)


if __name__ == '__main__':
    PROGRAM = sys.argv.pop(1)
    unittest.main()
