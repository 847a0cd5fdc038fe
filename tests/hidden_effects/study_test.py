#!/usr/bin/env python3
"""The study itself: its statistics against tabulated values, its judgement on made-up answers."""
import math
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from study import cases, figures, judgement, naming, real_rows, rivals, statistics as st  # noqa: E402


class Statistics(unittest.TestCase):
    def test_chi_square_quantiles_of_the_tables(self):
        for p, dof, x in ((0.05, 1, 3.841459), (0.05, 10, 18.307038), (0.01, 2, 9.210340), (0.001, 6, 22.457744)):
            self.assertAlmostEqual(st.chi_square_quantile_above(p, dof), x, places=5)
            self.assertAlmostEqual(st.chi_square_survival(x, dof), p, places=7)

    def test_two_degrees_of_freedom_in_closed_form_far_out(self):
        for x in (0.1, 5.0, 80.0, 600.0):
            self.assertAlmostEqual(st.chi_square_survival(x, 2) / math.exp(-0.5 * x), 1.0, places=9)

    def test_noncentral_of_one_degree_is_two_normal_tails(self):
        # (z + sqrt(nc))^2 > x
        for nc, x in ((1.0, 3.84), (40.0, 18.5), (400.0, 350.0)):
            mean, edge = math.sqrt(nc), math.sqrt(x)
            tails = st.normal_cdf(mean - edge) + st.normal_cdf(-mean - edge)
            self.assertAlmostEqual(st.noncentral_survival(x, 1, nc), tails, places=9)

    def test_clopper_pearson_of_the_textbooks(self):
        low, high = st.clopper_pearson(0, 1000)
        self.assertEqual(low, 0.0)
        self.assertAlmostEqual(high, 1.0 - 0.025 ** (1 / 1000), places=9)
        low, high = st.clopper_pearson(4, 20)
        self.assertAlmostEqual(low, 0.057334, places=5)
        self.assertAlmostEqual(high, 0.436614, places=5)

    def test_kolmogorov_smirnov_sees_a_shift_and_passes_a_grid(self):
        grid = [(i + 0.5) / 200 for i in range(200)]
        self.assertGreater(st.kolmogorov_smirnov(grid)[1], 0.99)
        self.assertLess(st.kolmogorov_smirnov([g ** 2 for g in grid])[1], 1e-6)


HIDDEN = {'kind': 'joint_harmonic', 'in_catalogue': True, 'target': 'A3', 'settings': {'order': '2'},
          'parameters': {'cos_urad': 50.0, 'sin_urad': -20.0}, 'further_orders': [3, 4]}


def step(order, target='A3', alternatives=()):
    return {'effect': 'joint_harmonic', 'target': target, 'settings': {'order': order}, 'alternatives': list(alternatives),
            'parameters': [{'name': 'cos_urad', 'value': 52.0, 'sigma': 1.5, 'ci95': [49.0, 55.0]},
                           {'name': 'sin_urad', 'value': -15.0, 'sigma': 2.0, 'ci95': [-19.0, -11.0]}]}


def judged(steps, verdict='explained'):
    diagnosis = {'verdict': verdict, 'steps': steps, 'candidates': [], 'baseline': {}, 'final': {}, 'unexplained': None,
                 'noise': {'scale': 1.0, 'ci95': [0.9, 1.1], 'repeatability_urad': None, 'outliers': []}}
    case = {'suite': 's', 'index': 0, 'group': 'strong', 'expects': 'catalogue', 'kinds': ['joint_harmonic']}
    answer = {'hidden': [HIDDEN], 'sigma_factor': 1.0, 'undeclared_repeatability_urad': 0.0, 'outliers': []}
    record = judgement.judge(case, {'flags': {}, 'scales': [1.0], 'nc': 400.0, 'nc_alone': [400.0]}, answer, diagnosis,
                             [{'sep': 30.0, 'best_rival': 'x', 'left': 1.0}])
    return dict(record, seconds=1.0, folder='f')


def apart(parameters, rivals_):
    return {'parameters': parameters, 'log_rows': 7.0, 'rivals': [
        {'effect': e, 'name': e, 'lead': lead, 'parameters': p} for e, lead, p in rivals_]}


class RuleOfChoosing(unittest.TestCase):
    def test_more_parameters_must_pay_for_themselves(self):
        chance = figures.rule_chance(apart(4, [('encoder_gain', 36.0, 1)]), 'gravity_compensator')
        self.assertAlmostEqual(chance, st.normal_cdf((36.0 - 3 * 7.0 - 6.0) / 12.0))
        chance = figures.rule_chance(apart(1, [('gravity_compensator', 4.0, 4)]), 'encoder_gain')
        self.assertAlmostEqual(chance, st.normal_cdf((4.0 + 21.0 + 6.0) / 4.0))

    def test_a_tie_goes_to_the_earlier_in_the_catalogue(self):
        chance = figures.rule_chance(apart(1, [('encoder_gain', 9.0, 1)]), 'joint_coupling')
        self.assertAlmostEqual(chance, st.normal_cdf((9.0 - 6.0) / 6.0))
        chance = figures.rule_chance(apart(1, [('joint_coupling', 9.0, 1)]), 'encoder_gain')
        self.assertAlmostEqual(chance, st.normal_cdf((9.0 + 6.0) / 6.0))

    def test_of_twins_one_in_two(self):
        self.assertEqual(figures.rule_chance(apart(1, [('station_scale', -1e-7, 1)]), 'station_scale'), 0.5)


class Judgement(unittest.TestCase):
    def test_the_truth_alone_is_exact(self):
        record = judged([step(2)])
        self.assertTrue(record['named_first'] and record['exact'] and record['named_or_listed'])
        self.assertEqual([p['inside'] for p in record['parameters']], [True, False])
        self.assertAlmostEqual(record['parameters'][1]['z'], 2.5)

    def test_values_conditional_on_a_held_parameter_are_not_compared(self):
        held = step(2)
        held['parameters'][0].update(sigma=0.0, ci95=[0.0, 0.0])
        self.assertEqual(judged([held])['parameters'], [])
        del held['parameters'][0]
        self.assertEqual(judged([held])['parameters'], [])

    def test_further_harmonics_of_the_same_gear_are_right_others_not(self):
        self.assertTrue(judged([step(2), step(3)])['exact'])
        self.assertFalse(judged([step(2), step(3, 'A4')])['exact'])
        self.assertFalse(judged([step(3)])['named_first'])

    def test_another_joint_or_order_is_wrong_but_may_list_the_truth(self):
        wrong = judged([step(2, 'A2')])
        self.assertFalse(wrong['named_first'] or wrong['named_or_listed'])
        alternative = {'effect': 'joint_harmonic', 'target': 'A3', 'settings': {'order': 2}}
        self.assertTrue(judged([step(2, 'A2', [alternative])])['named_or_listed'])

    def test_figures_count_what_was_judged(self):
        result = figures.all_figures([judged([step(2)]), judged([step(1)]), judged([], 'unknown')])
        self.assertEqual(result['naming']['by_nc']['NC >= 40']['named_first']['k'], 1)
        self.assertEqual(result['catalogue_called_unknown']['k'], 1)
        self.assertEqual(result['intervals']['coverage']['n'], 2)
        self.assertEqual(result['confusion']['joint_harmonic'],
                         {'joint_harmonic': 1, 'joint_harmonic (other target or setting)': 1, 'unknown': 1})


class Foreign(unittest.TestCase):
    @staticmethod
    def record(kind, verdict, steps, holdout):
        seen = judged([], verdict)
        return dict(seen, suite='foreign', group=kind, kinds=[kind], expects='outside', steps=steps,
                    holdout_rms_mm=holdout)

    def test_the_holdout_is_counted_where_effects_were_named(self):
        records = [self.record('seat_wear', 'explained', ['marker_shift/M1'], [0.03, 0.02]),
                   self.record('seat_wear', 'partly', ['marker_shift/M1'], [0.03, 0.04]),
                   self.record('seat_wear', 'unknown', [], [0.03, 0.03])]
        f = figures.all_figures(records)
        found = f['foreign']['seat_wear']
        self.assertEqual(found['verdicts'], {'explained': 1, 'partly': 1, 'unknown': 1})
        self.assertEqual(found['named'], {'marker_shift/M1': 2})
        self.assertEqual((found['holdout_worse']['k'], found['holdout_worse']['n']), (1, 2))
        self.assertEqual(f['outside']['all but steps, NC >= 80']['unknown']['n'], 0)

    def test_nothing_of_it_is_in_the_catalogue(self):
        lists = [cases.CATALOGUE, cases.OUTSIDE, cases.FOREIGN, cases.STRANGERS, cases.NEWCOMERS, cases.LATECOMERS]
        together = sum(lists, [])
        self.assertEqual(len(set(together)), len(together))
        self.assertLessEqual(set(cases.NEEDS_COLUMN) | cases.NEEDS_LOADS, set(together))
        drawn = list(cases.outside_suite('foreign', cases.FOREIGN)(5, 2, {}))
        self.assertEqual([c['group'] for c in drawn], 2 * cases.FOREIGN)
        self.assertTrue(all(80.0 <= c['sizes'][0] <= 2000.0 for c in drawn))


class Halves(unittest.TestCase):
    def test_they_share_no_pose_and_lose_no_row(self):
        data = real_rows.RealData.__new__(real_rows.RealData)
        data.joints = ['A1', 'A2']
        data.rows = [{'config': str(i), 'q1_deg': str(i // 3), 'q2_deg': '7'} for i in range(30)]
        one, other = data.halves('5')
        self.assertEqual(len(one), 15)
        self.assertEqual(sorted(one + other, key=lambda row: int(row['config'])), data.rows)
        self.assertFalse({data.pose(row) for row in one} & {data.pose(row) for row in other})
        self.assertNotEqual(one, data.halves('6')[0])

    def test_what_the_other_half_says_of_a_step(self):
        def step(order, joint, alternatives=()):
            return {'effect': 'joint_harmonic', 'target': joint, 'settings': {'order': order},
                    'alternatives': list(alternatives)}
        one = {'steps': [step(3, 'A1'), step(2, 'A2'), step(4, 'A2'), step(1, 'A3'), step(1, 'A4')]}
        other = {'steps': [step(5, 'A2', [step(4, 'A2')]), step(3, 'A1')]}
        told = naming.named_again(one, other, 4)
        self.assertEqual([(t['named'], t['listed'], t['same_joint']) for t in told],
                         [(True, True, True), (False, False, True), (False, True, True), (False, False, False)])

    def test_what_the_other_half_says_of_a_kind(self):
        def one(**kinds):
            return {'steps': [{'effect': effect} for effect in kinds],
                    'groups': [{'steps': [k], 'probability': p} for k, p in enumerate(kinds.values())]}
        here = one(joint_harmonic=0.95, hysteresis=0.7, others=None)
        there = one(joint_harmonic=0.6, hysteresis=0.4)
        self.assertEqual(naming.kinds_of(here), {'joint_harmonic': 0.95, 'hysteresis': 0.7})
        self.assertEqual(naming.groups_again(here, there, 0.9), [{'group': 'joint_harmonic', 'sure': False, 'likely': True}])
        self.assertEqual([g['likely'] for g in naming.groups_again(here, there, 0.6)], [False, True])


class Suites(unittest.TestCase):
    def test_a_case_depends_on_suite_seed_and_number_alone(self):
        options = {'sizes': None, 'kinds': None}
        for name, suite in cases.SUITES.items():
            few, many = list(suite(7, 2, options)), list(suite(7, 3, options))
            self.assertTrue(few, name)
            self.assertEqual(few, many[:len(few)], name)
            self.assertNotEqual(few, list(suite(8, 2, options)), name)

    def test_needed_columns_are_never_left_out(self):
        for case in cases.catalogue_suite(3, 20, {}):
            without = case['flags'].get('without', '').split(',')
            for kind in case['kinds']:
                self.assertNotIn(cases.NEEDS_COLUMN.get(kind), without)


class Rivals(unittest.TestCase):
    def test_lists_of_the_experiment_grow(self):
        text = 'estimate:\n  geometry: [a, b]\nvalidation: none\n'
        self.assertIn('geometry: [a, b, c]', rivals.add_to_list(text, 'geometry', 'c'))
        self.assertIn('  compliance: [A1]\nvalidation', rivals.add_to_list(text, 'compliance', 'A1'))


if __name__ == '__main__':
    unittest.main()
