"""Sagitta: robot calibration from measured points.

    experiment = sagitta.read("robot.yaml", "measurements.csv")
    estimate = sagitta.calibrate(experiment)
    print(estimate.verdict)
    estimate.to_dataframe()

Arrays are in SI (m, rad) and say so in their names; they have one row per reading, but for joint_values, which has one
per configuration (of corrected targets one per target). Frames and dictionaries are the files and the JSON of
docs/FORMATS.md, units in every name, with the numbers of the program to the last digit.
"""
import copy as _copy
import difflib as _difflib
import json as _json
import operator as _operator
import os as _os

import numpy as _np

from sagitta import _core, _tables

__version__ = _core.__version__


class InputError(ValueError):
    """Input that cannot be used: says where, and what to do about it. str(error) has place and hint, too."""

    file = ""
    line = 0  # of a table in memory its row, from 1
    key = ""
    hint = ""


class NumericalError(RuntimeError):
    """No result: the numbers are singular, do not converge, or a load folds the arm."""

    status = ""


def _unconditional(row):
    """(standard deviation, interval) that allow for what was held; None where nothing held makes them wider."""
    wide = row.get("unconditional")
    if wide is None or (row["sigma"] is not None and not wide["sigma"] > row["sigma"]):
        return None, None
    return wide["sigma"], tuple(wide["ci95"])


class Parameter:
    """One parameter in its own unit. sigma and ci95 assume that what was held is exact; unconditional does not."""

    def __init__(self, row):
        self.name = row["name"]
        self.value = row["value"]
        self.unit = row["unit"]
        self.nominal = row["nominal"]
        self.sigma = row["sigma"]
        self.ci95 = None if row["ci95"] is None else tuple(row["ci95"])
        self.free = row["free"]
        self.identifiable = row["identifiable"]
        self.unconditional, self.unconditional_ci95 = _unconditional(row)

    def __repr__(self):
        sigma = "" if self.sigma is None else ", sigma %.3g" % self.sigma
        allowing = "" if self.unconditional is None else ", sigma %.3g with what was held" % self.unconditional
        return "<%s = %.6g %s%s%s>" % (self.name, self.value, self.unit, sigma, allowing)


def _read_only(array):
    """Results are not written to: an array that is made anew at every access would lose it without a word."""
    array.setflags(write=False)
    return array


def _of_core(name, doc=None, read_only=False, called=False):
    """A property that hands on what the core has under this name."""
    def value(self):
        found = getattr(self._core, name)
        found = found() if called else found
        return _read_only(found) if read_only else found
    return property(value, doc=doc)


def _of_json(*keys, doc=None):
    """A property that stands under these keys of the result file; a copy, as to_dict() is."""
    def value(self):
        found = self._dict
        for key in keys:
            found = found[key]
        return _copy.deepcopy(found)
    return property(value, doc=doc)


class _Data:
    """What rows have, whoever made them."""

    def __init__(self, core):
        self._core = core

    def __len__(self):
        return len(self._core)

    markers = _of_core("markers")
    stations = _of_core("stations")
    configurations = _of_core("configurations")
    warnings = _of_core("warnings")
    joint_values = _of_core("joint_values", "As commanded, rad and m: one row per configuration, in the order of "
                            "`configurations`; to_dataframe() has them in every row.", read_only=True)
    points_m = _of_core("points_m", "As measured, in the station's frame, one row per reading.", read_only=True)

    def __reduce__(self):
        raise TypeError("rows and experiments are not pickled: hand over the arguments of sagitta.read, and read there")

    def to_csv(self, path):
        with open(path, "w", encoding="utf-8") as file:
            file.write(self._core.csv())

    def to_dataframe(self):
        return _tables.frame(self._core.csv())


class Rows(_Data):
    """Measurements: simulated, planned, or those of an estimate."""

    def __repr__(self):
        return "<%d rows, %d configurations>" % (len(self), len(self.configurations))


class Experiment(_Data):
    """A robot, measurements, and what is stated of both."""

    robot_name = _of_core("robot_name")
    joints = _of_core("joints")
    robot_yaml = _of_core("robot_yaml")

    def __repr__(self):
        return "<experiment: %s, %d rows, %d configurations>" % (self.robot_name or "robot", len(self),
                                                                  len(self.configurations))


class Known:
    """A robot with its surroundings as an estimate.json states them: all that predictions need."""

    def __init__(self, core):
        self._core = core

    robot_name = _of_core("robot_name")
    robot_yaml = _of_core("robot_yaml")

    def __reduce__(self):
        raise TypeError("a known robot is not pickled: hand over the path of its estimate.json, and sagitta.load it there")

    def predict(self, rows, *, force=False):
        return Prediction(self._core, rows, force)

    def validate(self, rows, *, force=False):
        return Validation(self._core, rows, force)

    def compensate(self, targets, *, threads=1):
        return Compensation(self._core, targets, threads)

    def linearize(self, rows):
        """At the parameters of the estimate, for any rows of its stations and markers: x, y, z may be missing."""
        return Linearization(_core.linearize(self._core, _rows(rows)))


class Linearization:
    """Readings and the identification Jacobian, SI: one row per coordinate (x, y, z) of a reading, in the frame of its
    station; a reading of a pose has three more, of its rotation.

    names: K, of the columns: parameters as in estimate.estimated.
    jacobian: M x K, d predicted / d parameter. m or rad of the reading, per m, rad (rotations: of a left perturbation
    R = exp(delta) R), or the SI unit of the parameter; whitened: of the reading by its standard deviation.
    residuals: M, measured - predicted, m, and rotation vectors, rad; nan where nothing was measured.
    rows: M, which row of the table, from 0, a coordinate is of.
    turns: M, True where it is one of a rotation, rad, and of no point, m.
    """

    def __init__(self, core):
        rows, turns = _np.array(core.rows, dtype=_np.intp), _np.array(core.turns, dtype=_np.bool_)
        order = _np.lexsort((turns, rows))  # stable; the rotation of a pose follows its point
        self.names = list(core.names)
        self.rows, self.turns = _read_only(rows[order]), _read_only(turns[order])
        self.jacobian = _read_only(core.jacobian[order])
        self.residuals = _read_only(core.residuals[order, 0])

    def __repr__(self):
        return "<linearization: %d x %d>" % self.jacobian.shape


class _WithJson:
    def __init__(self, core):
        self._core = core
        self._json = self._parsed = None

    @property
    def _text(self):
        if self._json is None:
            self._json = self._core.json()
        return self._json

    @property
    def _dict(self):
        """For reading alone: what users get is a copy."""
        if self._parsed is None:
            self._parsed = self.to_dict()
        return self._parsed

    def to_dict(self):
        return _json.loads(self._text)


class _WithKnown(_WithJson):
    def __init__(self, core):
        super().__init__(core)
        self._known = None

    @property
    def known(self):
        if self._known is None:
            self._known = Known(self._core.known())
        return self._known


class Estimate(_WithKnown):
    """What calibrate returns; to_dict() is estimate.json."""

    status = _of_json("status")

    verdict = _of_json("verdict", "words")
    trusted = _of_json("verdict", "trusted")
    fit = _of_json("fit")

    @property
    def validation(self):
        """The errors on rows that were held out, as in estimate.json; None where nothing is held out."""
        held_out = self._dict["validation"]
        return _copy.deepcopy(held_out) if held_out["observations"] > 0 else None

    cross_validation = _of_json(
        "cross_validation",
        doc="The errors on the calibration rows, each predicted by a fit without its configuration.")
    warnings = _of_json("warnings")

    @property
    def parameters(self):
        return {row["name"]: Parameter(row) for row in self._dict["parameters"]}

    def __contains__(self, name):
        return any(row["name"] == name for row in self._dict["parameters"])

    def __iter__(self):
        return iter([row["name"] for row in self._dict["parameters"]])

    def __len__(self):
        return len(self._dict["parameters"])

    def __getitem__(self, name):
        for row in self._dict["parameters"]:
            if row["name"] == name:
                return Parameter(row)
        near = _difflib.get_close_matches(str(name), [row["name"] for row in self._dict["parameters"]], 3, 0.5)
        raise KeyError("%s: no parameter%s" % (name, "; did you mean %s?" % " or ".join(near) if near else ""))

    estimated = _of_json("correlation", "names",
                         doc="The names of what was estimated, in the order of correlation and covariance_si.")

    @property
    def correlation(self):
        """Of the parameters `estimated`, by the noise alone."""
        return _read_only(_np.array(self._dict["correlation"]["matrix"], dtype=_np.float64))

    covariance_si = _of_core("covariance_si", "Of the parameters `estimated`, in SI, by the noise alone: sigma and ci95 "
                             "of a parameter hold model error as well.")

    @property
    def measured_m(self):
        return _read_only(self._core.rows.points_m)

    predicted_m = _of_core("predicted_m", read_only=True)

    @property
    def residuals_m(self):
        return _read_only(self.measured_m - self.predicted_m)

    whitened = _of_core("whitened", "Residuals by the root of what one reading scatters by.", read_only=True)
    leverage = _of_core("leverage", "One number per reading: the mean over its axes of the hat matrix's diagonal.",
                        read_only=True)
    robot_yaml = _of_core("robot_yaml", called=True)

    def predict(self, rows, *, force=False):
        return self.known.predict(rows, force=force)

    def validate(self, rows, *, force=False):
        return self.known.validate(rows, force=force)

    def compensate(self, targets, *, threads=1):
        return self.known.compensate(targets, threads=threads)

    def linearize(self, rows=None, *, whiten=False):
        """Residuals and Jacobian at the estimate: of the rows that were fitted, or of others, measured or not. whiten:
        of the fitted rows in units of their noise, readings of one visit that share the joints' deviations together."""
        whiten = _flag(whiten, "whiten")
        if rows is None:
            return Linearization(_core.linearize_fit(self._core, whiten))
        if whiten:
            raise _tables._input_error("whiten: the noise of rows that were not fitted is not known", "whiten",
                                       "divide them by the standard deviation that they will have")
        return self.known.linearize(rows)

    def to_dataframe(self):
        """One row per parameter, in the units of its column `unit`; unconditional: where it is wider than sigma."""
        import pandas
        rows = self._dict["parameters"]
        frame = pandas.DataFrame(rows).set_index("name")
        wide = [_unconditional(row) for row in rows]
        frame["unconditional"] = _np.array([sigma for sigma, _ in wide], dtype=_np.float64)
        for end, column in enumerate(("unconditional_low", "unconditional_high")):
            frame[column] = _np.array([None if ci95 is None else ci95[end] for _, ci95 in wide], dtype=_np.float64)
        for key in ("ci95", "ci95_noise_only"):
            ends = [(None, None) if cell is None else tuple(cell) for cell in frame[key]]
            frame[key + "_low"], frame[key + "_high"] = zip(*ends) if ends else ((), ())
        return frame.drop(columns=["ci95", "ci95_noise_only"])

    def residuals_dataframe(self):
        """residuals.csv."""
        return _tables.frame(self._core.residuals_csv())

    report_html = _of_core("report_html", "report.html: one page, nothing to fetch.", called=True)

    def __reduce__(self):
        raise TypeError("an estimate is not pickled: write(folder), then sagitta.load(folder + '/estimate.json')")

    def write(self, folder):
        """estimate.json, robot.calibrated.yaml, residuals.csv and report.html, all or none."""
        self._core.write(_tables.path_text(folder, "folder"))

    def __repr__(self):
        return "<estimate: %s, %d parameters, fit %.3g mm RMS>" % (self.status, len(self.estimated), self.fit["rms_mm"])


class Inspection(_WithJson):
    """What inspect returns; to_dict() is inspect.json."""

    findings = _of_json("findings")
    serious = _of_json("serious")
    report_html = _of_core("report_html", called=True)

    def to_dataframe(self):
        """One row per unknown: expected standard deviation, whether it can be determined."""
        import pandas
        return pandas.DataFrame(self._dict["parameters"]).set_index("name")

    def write(self, folder):
        """inspect.json and report.html."""
        self._core.write(_tables.path_text(folder, "folder"))

    def __repr__(self):
        return "<inspection: %d serious, %d findings>" % (self.serious, len(self.findings))


class Changed(_WithJson):
    """What changed between two estimates; to_dict() is changed.json."""

    words = _of_json("words")
    changes = _of_json("changes")
    nothing = _of_json("nothing")

    def to_dataframe(self):
        """One row per change."""
        import pandas
        rows = [{"what": change["what"], "target": change["target"], "value": change["value"], "unit": change["unit"],
                 "ci95_low": change["ci95"][0], "ci95_high": change["ci95"][1], "probability": change["probability"]}
                for change in self.changes]
        return pandas.DataFrame(rows, columns=["what", "target", "value", "unit", "ci95_low", "ci95_high",
                                               "probability"])

    def __repr__(self):
        return "<changed: %d changes>" % len(self.changes)


class Program:
    """A robot program with its points corrected."""

    def __init__(self, core):
        self._core = core

    text = _of_core("text", "bytes: a program has no stated encoding.")
    summary = _of_core("summary")
    warnings = _of_core("warnings", "Of effects that depend on the way to a point, and of model error.")

    @property
    def untouched(self):
        """{name, line, why} of every point that stays as it is."""
        return [{"name": name, "line": line, "why": why} for name, line, why in self._core.points if why]

    def to_dataframe(self):
        """The points that were solved, as the file of `sagitta compensate`."""
        return _tables.frame(self._core.csv() or "target\n")

    def write(self, path):
        self._core.write(_tables.path_text(path, "path"))

    def __repr__(self):
        points = self._core.points
        return "<program: %d of %d points corrected>" % (sum(not why for _, _, why in points), len(points))


class Diagnosis(_WithKnown):
    """What diagnose returns; to_dict() is diagnosis.json."""

    verdict = _of_json("verdict")
    words = _of_json("words")
    steps = _of_json("steps")
    robot_yaml = _of_core("robot_yaml", called=True)
    learnt_robot_yaml = _of_core(
        "learnt_robot_yaml",
        "The extended robot with smooth functions where something has no name; None: none stands out.", called=True)
    next_robot_yaml = _of_core(
        "next_robot_yaml",
        "The extended robot as the next campaign finds it; None: no effect of it goes with times.", called=True)
    report_html = _of_core("report_html", "report.html: one page, nothing to fetch.", called=True)

    def to_dataframe(self):
        """One row per parameter of each effect that was found."""
        import pandas
        rows = []
        for effect in self.steps:
            for parameter in effect["parameters"]:
                low, high = parameter["ci95"]
                rows.append({"effect": effect["effect"], "target": effect["target"], "parameter": parameter["name"],
                             "value": parameter["value"], "sigma": parameter["sigma"], "ci95_low": low,
                             "ci95_high": high, "p_value": effect["p_value"]})
        return pandas.DataFrame(rows, columns=["effect", "target", "parameter", "value", "sigma", "ci95_low",
                                               "ci95_high", "p_value"])

    def __repr__(self):
        return "<diagnosis: %s, %d effects>" % (self.verdict, len(self.steps))


class Prediction:
    """Points of rows, with how certain they are."""

    def __init__(self, known, rows, force=False):
        self._core = _core.predict(known, _rows(rows), _flag(force, "force"))

    points_m = _of_core("points_m", read_only=True)
    covariance_m2 = _of_core(
        "covariance_m2", "N x 3 x 3, of the mean: parameters with their model error, what was held, and what the "
        "calibration left; not of where the arm stops, nor of the instrument.", read_only=True)
    warnings = _of_core("warnings", "What `sagitta predict` warns of, and the model error that the figures carry.")

    def to_dataframe(self):
        """The file of `sagitta predict`."""
        return _tables.frame(self._core.csv())


class Validation(_WithJson):
    """Before and after on rows that were not calibrated; to_dict() is validation.json."""

    def __init__(self, known, rows, force=False):
        super().__init__(_core.validate(known, _rows(rows), _flag(force, "force")))

    before = _of_json("validation", "before")
    after = _of_json("validation")

    @property
    def warnings(self):
        """Those of validation.json, and the model error that the figures carry."""
        return self._core.with_model_error(self._dict["warnings"])

    report_html = _of_core("report_html", "report.html: one page, nothing to fetch.", called=True)
    predicted_m = _of_core("predicted_m", read_only=True)

    def to_dataframe(self):
        return _tables.frame(self._core.csv())


class Compensation:
    """Corrected targets, one row per row."""

    def __init__(self, known, targets, threads):
        self._core = _core.compensate(known, _tables.source(targets, "targets"), _whole(threads, "threads"))

    status = _of_core("status")
    warnings = _of_core(
        "warnings", "What `sagitta compensate` says of effects that depend on the way to a target, of targets outside "
        "the measured joint ranges and of model error.")
    joint_values = _of_core("joint_values", "To be commanded, rad and m, one row per target.", read_only=True)

    def to_dataframe(self):
        """The file of `sagitta compensate`."""
        return _tables.frame(self._core.csv())


class Plan(_WithJson):
    """Which poses to measure; to_dict() is plan.json."""

    @property
    def rows(self):
        return Rows(self._core.rows)

    def to_csv(self, path):
        with open(path, "w", encoding="utf-8") as file:
            file.write(self._core.csv())

    def to_dataframe(self):
        """plan.csv."""
        return _tables.frame(self._core.csv())

    report_html = _of_core("report_html", "report.html: one page, nothing to fetch.", called=True)


def _experiment(experiment):
    if not isinstance(experiment, Experiment):
        raise TypeError("an experiment is expected, as sagitta.read(...) gives it, not %s" % type(experiment).__name__)
    return experiment._core


def _names(names, key):
    """Any iterable of texts. One text is a list as well, as it is for the flags: "geometry/p_x1,geometry/p_y1"."""
    if names is None or isinstance(names, str):
        return _core.split_names(names) if names else []
    try:
        found = list(names)
    except TypeError:
        raise TypeError("%s: names are expected, not %s" % (key, type(names).__name__)) from None
    for name in found:
        if not isinstance(name, str):
            raise TypeError("%s: every name is a text, not %s" % (key, type(name).__name__))
    return found


def _whole(number, name, least=-2**31, most=2**31 - 1):
    """As an int of C++; what else it may be is asked there."""
    try:
        whole = _operator.index(number)
    except TypeError:
        raise TypeError("%s: a whole number is expected, not %r" % (name, number)) from None
    if not least <= whole <= most:
        raise _tables._input_error("%s: %d is too %s" % (name, whole, "small" if whole < least else "large"), name)
    return whole


def _number(number, name):
    try:
        return float(number)
    except (TypeError, ValueError):
        raise TypeError("%s: a number is expected, not %r" % (name, number)) from None


def _numbers(numbers, name):
    try:
        return [_number(number, name) for number in numbers]
    except TypeError:
        raise TypeError("%s: numbers are expected, not %r" % (name, numbers)) from None


def _flag(flag, name):
    if isinstance(flag, (bool, _np.bool_)) or (isinstance(flag, int) and flag in (0, 1)):
        return bool(flag)
    raise TypeError("%s: True or False is expected, not %r" % (name, flag))


def _word(word, name):
    if not isinstance(word, str):
        raise TypeError("%s: a text is expected, not %r" % (name, word))
    return word


def _heard(progress):
    if progress is not None and not callable(progress):
        raise TypeError("progress: a function that is called with a text is expected, not %r" % (progress,))
    return progress


def _seed(seed):
    return _whole(seed, "seed", 0, 2**64 - 1)


def _sources(tables, name):
    """One table, or a list of them; the rows of a result are a table, too, and keep every cell."""
    def table(one):
        return _tables.Written(one._core.csv()) if isinstance(one, _Data) else one
    return _tables.sources([table(one) for one in tables] if isinstance(tables, (list, tuple)) else table(tables), name)


def _rows(rows):
    return _sources(rows, "rows")


def _path_or_text(robot, name):
    """(path or text, whether it is text: of several lines, or of JSON or XML)"""
    if isinstance(robot, (str, _os.PathLike)):
        text = _tables.path_text(robot, name)
        return text, "\n" in text or text.lstrip()[:1] in ("{", "<")
    if not hasattr(robot, "keys"):
        raise TypeError("%s: a path, its text or a dictionary of its keys is expected, not %s"
                        % (name, type(robot).__name__))
    return _json.dumps(_plain(robot, "")), True


def _plain(value, key):
    """What stands under a key, as JSON has it; NumPy's numbers and arrays are numbers and lists."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if hasattr(value, "keys"):
        return {str(name): _plain(value[name], "%s.%s" % (key, name) if key else str(name)) for name in value.keys()}
    if isinstance(value, (list, tuple)):
        return [_plain(item, "%s[%d]" % (key, i)) for i, item in enumerate(value)]
    if value is None or isinstance(value, (str, bool, int, float)):
        return value
    raise _tables._input_error("%s: a number, a text, a list or a dictionary is expected, not %s"
                               % (key, type(value).__name__), key)


def read(robot_or_experiment, *measurements, sigma_mm=None, holdout=None, seed=None, free=(), fixed=(),
         points_required=True, **settings):
    """An experiment: one file sagitta/experiment/1, or a robot and its measurements.

    robot: a path (YAML, URDF), its text, or a dictionary of its keys. measurements: paths, pandas frames, mappings of
    columns, named as in docs/FORMATS.md section 2, or rows that a call gave (simulate, plan, read); arrays of several
    columns are q_deg, xyz_mm, sigma_mm, ...
    settings: the keys of an experiment file, as noise={"sigma_mm": 0.05}.
    sigma_mm (mm), holdout (a fraction), seed, free, fixed (any iterable of names, or one text): the flags of `sagitta
    calibrate`; they replace what file or rows say. seed: of the rows that are held out. points_required=False: rows may
    lack x, y, z, as for simulate and plan. Raises InputError.
    """
    required = _flag(points_required, "points_required")
    if not measurements:
        path, is_text = _path_or_text(robot_or_experiment, "robot")
        if is_text:
            raise _tables._input_error("the measurements are missing", "measurements",
                                       "read(ROBOT, MEASUREMENTS), or the path of an experiment file")
        if settings:
            raise _tables._input_error("an experiment file states its own '%s'" % next(iter(settings)),
                                       next(iter(settings)), "change it there, or give a robot and measurements")
        core = _core.read([path], sigma_mm is None, required)
    else:
        text, is_text = _path_or_text(robot_or_experiment, "robot")
        tables = []
        for i, table in enumerate(measurements):
            tables += _sources(table, "measurements" if len(measurements) == 1 else "measurements[%d]" % i)
        core = _core.assemble(text, is_text, tables, _json.dumps(_plain(settings, "")), sigma_mm is None, required)
    if sigma_mm is not None:
        core.set_sigma(_number(sigma_mm, "sigma_mm"))
    if holdout is not None:
        core.set_holdout(_number(holdout, "holdout"), 1 if seed is None else _seed(seed))
    elif seed is not None:
        core.set_validation_seed(_seed(seed))
    for names, key, replace in ((free, "free", core.set_free), (fixed, "fixed", core.set_fixed)):
        listed = _names(names, key)
        if listed:
            replace(listed)
    return Experiment(core)


def load(path):
    """The robot of an estimate.json."""
    return Known(_core.load(_tables.path_text(path, "path")))


def calibrate(experiment, *, method="joint", threads=1, seed=1, force=False, progress=None):
    """Everything unknown in one solve.

    method: as --method. threads: results do not depend on how many. seed: of the random halves that are compared.
    force: goes on where the nominal robot cannot have made the readings. progress: called with a sentence now and then.
    Raises InputError, and NumericalError where there is no estimate.
    """
    inputs = _experiment(experiment)
    return Estimate(_core.calibrate(inputs, _word(method, "method"), _whole(threads, "threads"), _seed(seed),
                                    _flag(force, "force"), "sagitta.calibrate", _heard(progress)))


def diagnose(experiment, *, threads=1, force=False, progress=None):
    """Finds, names and adds the effect that the model lacks."""
    return Diagnosis(_core.diagnose(_experiment(experiment), _whole(threads, "threads"), _flag(force, "force"),
                                    "sagitta.diagnose", _heard(progress)))


def inspect(experiment, *, progress=None):
    """What a data set can determine, and what is wrong with it, without an estimate."""
    return Inspection(_core.inspect(_experiment(experiment), "sagitta.inspect", _heard(progress)))


def _known(estimate):
    if isinstance(estimate, (str, _os.PathLike)):
        return load(estimate)
    if isinstance(estimate, Known):
        return estimate
    if not hasattr(estimate, "known"):
        raise TypeError("an estimate is expected, as sagitta.calibrate(...) gives it, or the path of an estimate.json, "
                        "not %s" % type(estimate).__name__)
    return estimate.known


def predict(estimate, rows, *, force=False):
    """Points of rows (x, y, z may be absent) from an estimate, a Known robot, or the path of an estimate.json. Rows that
    the robot cannot have made are an error; force=True goes on."""
    return _known(estimate).predict(rows, force=force)


def validate(estimate, rows, *, force=False):
    """Before and after on configurations that the estimate has not seen. Rows that the robot cannot have made are an
    error; force=True goes on."""
    return _known(estimate).validate(rows, force=force)


def compensate(estimate, targets, *, threads=1):
    """Corrected joint values for targets: a path, a frame or columns (docs/COMPENSATION.md)."""
    return _known(estimate).compensate(targets, threads=threads)


def changed(old, new):
    """What changed between two estimates of one robot beyond both uncertainties (docs/COMPENSATION.md)."""
    return Changed(_core.changed(_known(old)._core, _known(new)._core))


def _frames(frames, name):
    """{"world": "same", "TOOL_DATA[1]": (x, y, z, roll, pitch, yaw)} as the program reads it, or its text."""
    if frames is None or isinstance(frames, str):
        return frames or ""
    if not hasattr(frames, "items"):
        raise TypeError("%s: a dictionary of names is expected, not %r" % (name, frames))
    parts = []
    for key, pose in frames.items():
        numbers = pose if isinstance(pose, str) else ",".join(map(repr, _numbers(pose, name)))
        parts.append("%s=%s" % (key, numbers))
    return ";".join(parts)


def compensate_program(estimate, program, *, tools_mm_deg=None, frames_mm_deg=None, start_deg=(), load="",
                       loads_kg_mm=None, turn_joints=(), threads=1):
    """A robot program (path) with its points corrected; what the file does not state is asked for by name.

    load: one of the estimate or "none", for all points; "": what the program states. loads_kg_mm: mass and centre of
    mass in the controller's flange of loads that it only names. turn_joints: what FANUC's turn numbers count.
    """
    return Program(_core.compensate_program(
        _known(estimate)._core, _tables.path_text(program, "program"), _frames(tools_mm_deg, "tools_mm_deg"),
        _frames(frames_mm_deg, "frames_mm_deg"), _numbers(start_deg, "start_deg"), _word(load, "load"),
        _frames(loads_kg_mm, "loads_kg_mm"), _numbers(turn_joints, "turn_joints"), _whole(threads, "threads")))


def simulate(experiment, truth=None, *, sigma_mm=None, seed=1):
    """The rows of an experiment as an instrument would have read them.

    truth: an estimate, a Known robot, the path of an estimate.json; None: the experiment with its stations and markers.
    """
    inputs = _experiment(experiment)
    known = _core.truth_of(inputs) if truth is None else _core.with_loads_of(_known(truth)._core, inputs)
    sigma = None if sigma_mm is None else _number(sigma_mm, "sigma_mm")
    return Rows(_core.simulate(known, inputs, sigma, _seed(seed)))


def _estimate_text(estimate):
    """(text of an estimate.json, its name)"""
    if estimate is None:
        return "", ""
    if isinstance(estimate, Estimate):
        return estimate._text, "model_error"
    if not isinstance(estimate, (str, _os.PathLike)):
        raise TypeError("model_error: an estimate is expected, as sagitta.calibrate(...) gives it, or the path of an "
                        "estimate.json, not %s" % type(estimate).__name__)
    path = _tables.path_text(estimate, "model_error")
    return _core.text_of(path), path


def plan(experiment, *, poses=None, accuracy_mm=None, augment=False, criterion="I", discriminate=(), candidates=None,
         tests=None, pool=500, cell=None, model_error=None, move=True, seed=1, progress=None):
    """Which poses to measure, how many, and how good the calibration will be.

    tests: rows, or "random". cell: what poses keep to, the path of a cell.yaml, its text or a dict of its keys.
    model_error: an estimate of a former calibration, or the path of its estimate.json: what it shows to be wrong with
    the model is part of the plan. move: drawn poses may move to where they are more informative.
    """
    if (poses is None) == (accuracy_mm is None):
        raise _tables._input_error("one of poses and accuracy_mm says how many", "poses", "poses=20")
    inputs = _experiment(experiment)
    random_tests = isinstance(tests, str) and tests == "random"
    wishes = {
        "poses": None if poses is None else _whole(poses, "poses"),
        "accuracy_mm": None if accuracy_mm is None else _number(accuracy_mm, "accuracy_mm"),
        "augment": _flag(augment, "augment"), "criterion": _word(criterion, "criterion"),
        "discriminate": ",".join(_names(discriminate, "discriminate")),
        "pool": _whole(pool, "pool"),
        "seed": _seed(seed), "random_tests": random_tests,
        "candidates": [] if candidates is None else _sources(candidates, "candidates"),
        "tests": [] if tests is None or random_tests else _sources(tests, "tests"),
        "cell": ("", False) if cell is None else _path_or_text(cell, "cell"),
        "move": _flag(move, "move"),
        "model_error": _estimate_text(model_error),
    }
    return Plan(_core.plan(inputs, wishes, "sagitta.plan", _heard(progress)))


__all__ = ["Changed", "Compensation", "Diagnosis", "Estimate", "Experiment", "InputError", "Inspection", "Known",
           "Linearization", "NumericalError", "Parameter", "Plan", "Prediction", "Program", "Rows", "Validation",
           "calibrate", "changed", "compensate", "compensate_program", "diagnose", "inspect", "load", "plan", "predict",
           "read", "simulate", "validate"]
