"""Tables as users have them (files, pandas frames, mappings of columns) on their way to the C++ core, and back."""
import io
import os

import numpy as np

# Arrays of more than one column, in place of single columns: stem and unit -> names of the single ones.
_AXES = ("x", "y", "z")
_WIDE = {
    "xyz": list(_AXES),
    "sigma": ["sigma_" + a for a in _AXES],
    "rotvec": ["r" + a for a in _AXES],
    "sigma_r": ["sigma_r" + a for a in _AXES],
    "force": ["f" + a for a in _AXES],
    "moment": ["m" + a for a in _AXES],
    "sim": ["sim_" + a for a in _AXES],
}
_NUMBERED = ("q", "tau", "approach")
_TEXTS = {name: str for name in ("config", "marker", "station", "visit", "repeat", "load", "set", "target", "status",
                                "words")}


def _single_columns(name, values):
    """The single columns that an array of n rows and several columns stands for; views of it, nothing is copied."""
    stem, bar, unit = name.rpartition("_")
    if not bar:
        stem, unit = name, ""
    tail = bar + unit
    if stem in _NUMBERED:
        names = ["%s%d%s" % (stem, i + 1, tail) for i in range(values.shape[1])]
    elif stem in _WIDE and values.shape[1] == 3:
        names = [axis + tail for axis in _WIDE[stem]]
    else:
        raise _input_error("'%s' has %d columns" % (name, values.shape[1]), name,
                           "arrays of several columns are q_deg, xyz_mm, sigma_mm, rotvec_mrad, force_N, moment_Nm")
    return [(single, values[:, i]) for i, single in enumerate(names)]


def _input_error(what, key, hint=""):
    from sagitta import InputError
    error = InputError(what + (" (%s)" % hint if hint else ""))
    error.key, error.hint = key, hint
    return error


def _is_missing(value):
    return value is None or value is np.ma.masked or value != value or str(value) == "<NA>"


def _text(value):
    if _is_missing(value):
        return ""
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    return str(value)


def _unmasked(values):
    """An array with nothing where values are masked: what lies under a mask is no value."""
    mask = np.ma.getmaskarray(values)
    if values.dtype.kind in "fiu":
        return np.where(mask, np.nan, np.ma.getdata(values).astype(np.float64))
    cells = np.ma.getdata(values).astype(object)
    cells[mask] = None
    return cells


def _column(name, values):
    """[(name, float64 array or list of texts)]"""
    array = values.to_numpy() if hasattr(values, "to_numpy") else np.asanyarray(values)
    if array.dtype.kind == "c":
        raise _input_error("'%s' holds complex numbers" % name, name)
    if np.ma.isMaskedArray(array):
        array = _unmasked(array)
    array = np.asarray(array)
    if array.ndim == 2:
        return _single_columns(name, np.asarray(array, dtype=np.float64))
    if array.ndim != 1:
        raise _input_error("'%s' has %d dimensions" % (name, array.ndim), name, "one value per row")
    if array.dtype.kind in "fiu":
        return [(name, np.asarray(array, dtype=np.float64))]
    return [(name, [_text(value) for value in array])]


def source(table, name):
    """A path as text, anything with columns as (name, {column: values})."""
    if isinstance(table, (str, os.PathLike)):
        return os.fspath(table)
    if not hasattr(table, "keys"):
        raise _input_error("%s: a path, a pandas frame or a mapping of columns is expected, not %s"
                           % (name, type(table).__name__), name)
    columns = {}
    for key in table.keys():
        for single, values in _column(str(key), table[key]):
            if single in columns:
                raise _input_error("column '%s' is given twice" % single, single)
            columns[single] = values
    return (name, columns)


def sources(tables, name):
    """One table, or a list of them."""
    if isinstance(tables, (list, tuple)):
        return [source(table, "%s[%d]" % (name, i)) for i, table in enumerate(tables)]
    return [source(tables, name)]


def frame(csv):
    """A pandas frame of a file that the library writes, to the last digit."""
    import pandas
    return pandas.read_csv(io.StringIO(csv), float_precision="round_trip", comment=None, dtype=_TEXTS,
                           keep_default_na=False, na_values=[""])
