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
ROWS = 10008      # of a long page
MOST_TIMES = 2.0  # as many elements as a page of 54 rows has, which is what a browser needs its time for
PROGRAM = ''
CHROMIUM = shutil.which('chromium')


DRAWN = 'document.documentElement.dataset.drawn'
CLOSED = "document.querySelectorAll('body > details:not([open])').length"
FIGURES = '''JSON.stringify([...document.querySelectorAll('figure.picture')].map((figure) => {
  const picture = JSON.parse(figure.querySelector('script').textContent);
  return {kind: picture.kind, data: picture.data, labels: picture.menus.x ? picture.menus.x.labels : [],
          texts: [...figure.querySelectorAll('svg text')].map((text) => text.textContent),
          points: figure.querySelectorAll('.points path').length,
          path: [...figure.querySelectorAll('.points path')].map((path) => path.getAttribute('transform')).join()};
}))'''
CHOOSE = '''(() => {
  const menu = [...document.querySelectorAll('.menus select')].find((one) => one.options[0].text.startsWith('A1'));
  menu.selectedIndex = %d;
  menu.dispatchEvent(new Event('change'));
})()'''
# What a page complains of, and what it asks for.
EVENTS = ('Runtime.consoleAPICalled', 'Runtime.exceptionThrown', 'Log.entryAdded', 'Network.requestWillBeSent')
# Of a picture with one bar or row for each name, the names that are shown at first.
NAMES = {
    'bars': lambda data: [name for name, group in zip(data['rows']['name'], data['rows']['group'])
                          if group == data['rows']['group'][0]],
    'waterfall': lambda data: data['stages']['stage'],
    'parameters': lambda data: [name for name, group in zip(data['rows']['name'], data['rows']['group'])
                                if group == data['rows']['group'][0]],
}


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
        self.unread, self.calls, self.target, self.session, self.said = b'', 0, None, None, []

    def begin(self, width):
        """A page of its own, empty, in place of the one before."""
        if self.target:
            self.call('Target.closeTarget', on_browser=True, targetId=self.target)
        self.target = self.call('Target.createTarget', on_browser=True, url='about:blank')['targetId']
        self.session = self.call('Target.attachToTarget', on_browser=True, targetId=self.target, flatten=True)['sessionId']
        self.said = []
        self.call('Emulation.setDeviceMetricsOverride', width=width, height=900, deviceScaleFactor=1, mobile=False)

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
            if answer.get('method') in EVENTS:
                self.said.append(answer)
            if answer.get('id') == self.calls:
                return answer.get('result', {})

    def value(self, expression):
        return self.call('Runtime.evaluate', expression=expression, returnByValue=True)['result'].get('value')

    def open(self, path):
        """Loads a page with all of it unfolded and drawn; its elements, and what it complains of or asks for."""
        for domain in ('Runtime', 'Log', 'Network'):
            self.call(domain + '.enable')
        self.load(path)
        self.value("window.dispatchEvent(new Event('beforeprint'))")
        asked = [one for one in self.said
                 if one.get('params', {}).get('request', {}).get('url', '') not in (path.as_uri(), 'about:blank')]
        return self.value('document.documentElement.outerHTML'), asked

    def load(self, path):
        """Until every picture on screen is drawn."""
        self.call('Page.navigate', url=path.as_uri())
        for _ in range(3000):
            if self.value("location.protocol === 'file:' && performance.getEntriesByName('drawn').length > 0"):
                return
            time.sleep(0.1)
        raise TimeoutError('%s is not drawn' % path)

    def close(self):
        self.call('Browser.close', on_browser=True)
        self.process.wait(timeout=60)
        os.close(self.write_end)
        os.close(self.read_end)


ROBOT = str(ROOT / 'problems/published/kr270/robot.yaml')


def run(*words):
    subprocess.run([PROGRAM, *words, '--quiet'], check=True, capture_output=True)


def write_poses(path, poses, stations):
    """Poses at random, three markers each."""
    random.seed(5)
    ranges = [(-150, 150), (-140, -10), (-100, 140), (-170, 170), (-110, 110), (-170, 170)]
    lines = ['config,marker,station,' + ','.join('q%d_deg' % (j + 1) for j in range(6))]
    for pose in range(poses):
        values = ','.join('%.3f' % random.uniform(*ends) for ends in ranges)
        lines += ['C%d,%s,%s,%s' % (pose, marker, station, values)
                  for station in stations for marker in ('P1', 'P2', 'P3')]
    path.write_text('\n'.join(lines) + '\n')


def ten_thousand_rows(folder):
    """The page of a calibration of ROWS simulated rows."""
    write_poses(folder / 'poses.csv', ROWS // 6, ('S1', 'S2'))
    run('calibrate', EXPERIMENT, '--out=%s' % (folder / 'truth'))
    run('simulate', ROBOT, str(folder / 'poses.csv'), '--truth=%s' % (folder / 'truth/estimate.json'),
        '--sigma_mm=0.05', '--out=%s' % (folder / 'rows.csv'))
    run('calibrate', ROBOT, str(folder / 'rows.csv'), '--sigma_mm=0.05', '--out=%s' % (folder / 'many'))
    return folder / 'many/report.html'


def one_row_far_off(folder):
    """The page of 420 configurations, three markers each, 42 of them held out; one reading is 10 mm off."""
    write_poses(folder / 'hundreds.csv', 420, ('S1',))
    run('calibrate', EXPERIMENT, '--out=%s' % (folder / 'truth'))
    run('simulate', ROBOT, str(folder / 'hundreds.csv'), '--truth=%s' % (folder / 'truth/estimate.json'),
        '--sigma_mm=0.05', '--out=%s' % (folder / 'far.csv'))
    lines = (folder / 'far.csv').read_text().splitlines()
    cells, z = lines[100].split(','), lines[0].split(',').index('z_mm')
    cells[z] = str(float(cells[z]) + 10.0)
    lines[100] = ','.join(cells)
    (folder / 'far.csv').write_text('\n'.join(lines) + '\n')
    run('calibrate', ROBOT, str(folder / 'far.csv'), '--sigma_mm=0.05', '--holdout=0.1', '--out=%s' % (folder / 'far'))
    return folder / 'far/report.html'


def two_effects(folder):
    """The page of a diagnosis that finds two effects with names longer than a phone is wide."""
    write_poses(folder / 'few_poses.csv', 60, ('S1',))
    effects = ('effects: [{effect: joint_harmonic, joint: A3, order: 1, cos_urad: 210, sin_urad: 60}, '
               '{effect: axis_wobble, joint: A1, order: 2, u_cos_urad: 200, v_sin_urad: 150}]\n')
    (folder / 'wavy.yaml').write_text(re.sub(r'(?m)^effects:.*\n', '', pathlib.Path(ROBOT).read_text()) + effects)
    (folder / 'wavy_experiment.yaml').write_text(
        'schema: sagitta/experiment/1\nrobot: wavy.yaml\nmeasurements: [few_poses.csv]\n'
        'stations: {S1: {xyz_mm: [0, 0, 0]}}\n'
        'markers: {P1: {xyz_mm: [280, -40, -90]}, P2: {xyz_mm: [280, -50, 90]}, P3: {xyz_mm: [280, 100, 0]}}\n')
    wavy = str(folder / 'wavy_experiment.yaml')
    run('simulate', wavy, '--truth=%s' % wavy, '--sigma_mm=0.03', '--out=%s' % (folder / 'wavy.csv'))
    run('diagnose', ROBOT, str(folder / 'wavy.csv'), '--sigma_mm=0.03', '--holdout=0.3',
        '--out=%s' % (folder / 'effects'))
    return folder / 'effects/report.html'


class ReportPages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.pages, cls.opened = {}, None
        for name, command in COMMANDS.items():
            out = pathlib.Path(cls.folder.name) / name
            subprocess.run([PROGRAM, *command, '--quiet', '--out=%s' % out], check=True, capture_output=True)
            cls.pages[name] = out / 'report.html'
        cls.pages['effects'] = two_effects(pathlib.Path(cls.folder.name))

    @classmethod
    def tearDownClass(cls):
        if cls.opened:
            cls.opened.close()
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

    def browser(self, width):
        """The browser with an empty page; one for all tests, because to start it costs as much as a page."""
        if CHROMIUM is None:
            self.skipTest('chromium is not installed (tools/install-dependencies --tests)')
        if 'id="templates"' not in self.pages['calibrate'].read_text():
            self.skipTest('built without libjs-vega and libjs-three')
        if self.opened is None:
            type(self).opened = Browser(str(pathlib.Path(self.folder.name) / 'profile'))
        self.opened.begin(width)
        return self.opened

    def test_on_paper_every_section_is_open_and_drawn(self):
        browser = self.browser(1000)
        browser.load(self.pages['diagnose'])
        figures = browser.value("document.querySelectorAll('figure.picture').length")
        closed = browser.value(CLOSED)
        self.assertGreater(closed, 0)
        self.assertLess(int(browser.value(DRAWN)), figures)
        browser.value("window.dispatchEvent(new Event('beforeprint'))")
        self.assertEqual(browser.value(CLOSED), 0)
        self.assertEqual(int(browser.value(DRAWN)), figures)
        browser.value("window.dispatchEvent(new Event('afterprint'))")
        self.assertEqual(browser.value(CLOSED), closed)

    def test_on_a_phone_every_name_of_a_bar_stands_whole(self):
        browser = self.browser(360)
        browser.load(self.pages['effects'])
        browser.value("window.dispatchEvent(new Event('beforeprint'))")
        pictures = 0
        for figure in json.loads(browser.value(FIGURES)):
            names = NAMES.get(figure['kind'], lambda data: [])(figure['data'])
            pictures += len(names) > 0
            for name in names:
                self.assertIn(name, figure['texts'], figure['kind'])
        self.assertGreater(pictures, 2)

    def test_a_scatter_shows_the_columns_that_are_chosen(self):
        browser = self.browser(1000)
        browser.load(self.pages['calibrate'])
        browser.value("window.dispatchEvent(new Event('beforeprint'))")
        seen = set()
        for option in range(3):
            browser.value(CHOOSE % option)
            time.sleep(0.5)
            figure = [one for one in json.loads(browser.value(FIGURES)) if one['kind'] == 'scatter'][0]
            self.assertEqual(figure['points'], 54)
            self.assertIn(figure['labels'][option], figure['texts'])
            seen.add(figure['path'])
        self.assertEqual(len(seen), 3)

    def test_a_page_of_ten_thousand_rows_holds_little_more_than_one_of_54(self):
        many = ten_thousand_rows(pathlib.Path(self.folder.name))
        self.assertLess(many.stat().st_size, 4 << 20)
        elements = []
        for page in (many.parents[1] / 'truth/report.html', many):
            browser = self.browser(1100)
            browser.load(page)
            self.assertGreater(int(browser.value(DRAWN)), 0)
            elements.append(browser.value("document.getElementsByTagName('*').length"))
        print('elements of the page: %d of 54 rows, %d of %d' % (*elements, ROWS))
        self.assertLess(elements[1], MOST_TIMES * elements[0])

    def test_every_picture_is_drawn_and_nothing_is_complained_of_or_asked_for(self):
        for name, path in self.pages.items():
            browser = self.browser(1100)
            shown, said = browser.open(path)
            self.assertEqual(said, [], name)
            figures = shown.count('<figure class="picture">')
            self.assertGreater(figures, 0)
            self.assertTrue('data-ready="yes"' in shown and 'data-drawn="%d"' % figures in shown, name)
            places = re.findall(r'<div class="place"[^>]*>(.{0,40})', shown, re.S)
            self.assertEqual(len(places), figures)
            for place in places:
                self.assertRegex(place, r'^(<svg|<canvas|<div class="|<form)', name)

    def test_few_held_out_points_lie_on_top_of_the_fitted(self):
        browser = self.browser(1100)
        shown, _ = browser.open(self.pages['few'])
        points = re.search(r'role-mark points".*?</g>', shown, re.S).group(0)
        drawn = re.findall(r'fill="([^"]*)" fill-opacity="([^"]*)"', points)
        self.assertEqual(len(drawn), 54)
        fitted, held_out = ('#0072b2', '0.6'), ('#d55e00', '1')  # 2 of 18 configurations, three markers each
        self.assertEqual(drawn, [fitted] * 48 + [held_out] * 6)

    def test_of_hundreds_of_poses_the_held_out_ones_keep_their_colour(self):
        page = one_row_far_off(pathlib.Path(self.folder.name))
        browser = self.browser(1100)
        shown, _ = browser.open(page)
        figures = json.loads(browser.value(FIGURES))
        points = re.search(r'role-mark points".*?</g>', shown, re.S).group(0)
        colours = re.findall(r'fill="([^"]*)" fill-opacity', points)
        self.assertEqual(colours, ['#0072b2'] * (3 * 378) + ['#d55e00'] * (3 * 42))
        # A point that is far off does not press all others into a line: most of them cover most of the height.
        scatter = [figure for figure in figures if figure['kind'] == 'scatter'][0]
        heights = sorted(float(y) for y in re.findall(r'translate\([^,]*,([^)]*)\)', scatter['path']))
        self.assertEqual(len(heights), 3 * 420)
        self.assertGreater(heights[1197] - heights[63], 0.2 * (heights[-1] - heights[0]))
        self.assertIn('1 beyond the axis, at its edge', scatter['texts'])

    def test_suspects_and_directions_are_lists(self):
        for name, path in self.pages.items():
            text = re.sub(r'<script.*?</script>', '', path.read_text(), flags=re.S)
            self.assertNotIn('<p>- ', text, name)


if __name__ == '__main__':
    PROGRAM = sys.argv.pop(1)
    unittest.main()
