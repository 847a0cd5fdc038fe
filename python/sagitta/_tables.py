"""Tables as users have them (files, pandas frames, mappings of columns) on their way to the C++ core, and back."""
import decimal
import io
import os
import re

import numpy as np

from sagitta._core import unguarded as _unguarded

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
_ISOTROPIC = ("sigma", "sigma_r")  # one number per row is that of all three axes
_NUMBERED = ("q", "tau", "approach")
_TEXTS = ("config", "marker", "station", "visit", "repeat", "load", "set", "target", "status", "words")
# What has one of them in its name holds numbers.
_UNITS = ("um", "mm", "m", "mm2", "deg", "rad", "mrad", "urad", "mrad2", "N", "Nm", "kg", "s", "degC")


def _single_columns(name, values, rows):
    """The single columns that an array of n rows and several columns stands for; views of it, nothing is copied.

    rows: how many the table has, as its other columns state.
    """
    stem, unit = _parted(name)
    if stem in _NUMBERED:
        names = ["%s%d%s" % (stem, i + 1, unit) for i in range(values.shape[1])]
    elif stem in _WIDE:
        names = [axis + unit for axis in _WIDE[stem]]
    else:
        raise _input_error("'%s' has %d columns" % (name, values.shape[1]), name,
                           "arrays of several columns are q_deg, xyz_mm, sigma_mm, rotvec_mrad, force_N, moment_Nm")
    if values.shape[1] != len(names) or values.shape[0] != rows == values.shape[1]:
        is_turned = values.shape[1] == rows or values.shape[0] == len(names)
        raise _input_error("'%s' has %d rows and %d columns" % (name, *values.shape), name,
                           "transposed? one row per reading is expected: %s.T" % name if is_turned else
                           "%d columns are expected: %s" % (len(names), ", ".join(names)))
    return [(single, values[:, i]) for i, single in enumerate(names)]


def _parted(name):
    """(stem, _unit) of the name of an array; no unit: empty"""
    stem, bar, unit = name.rpartition("_")
    return (stem, bar + unit) if bar else (name, "")


def _input_error(what, key, hint=""):
    from sagitta import InputError
    error = InputError(what + (" (%s)" % hint if hint else ""))
    error.key, error.hint = key, hint
    return error


def path_text(path, name):
    """A path as the library has it: in UTF-8."""
    text = os.fsdecode(os.fspath(path))
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        raise _input_error("%s: the path %r is not in UTF-8" % (name, text), name,
                           "rename the file or its folder") from None
    return text


def _is_missing(value):
    # What compares with itself as neither true nor false (pandas.NA) comes first.
    return value is None or value is np.ma.masked or str(value) == "<NA>" or value != value


def _text(value):
    if _is_missing(value):
        return ""
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    return value.decode("utf-8") if isinstance(value, bytes) else str(value)


def _no_text(name, error):
    return _input_error("'%s': %r is no text in UTF-8" % (name, error.object), name)


def _unmasked(values):
    """An array with nothing where values are masked: what lies under a mask is no value."""
    mask = np.ma.getmaskarray(values)
    if values.dtype.kind in "fiu":
        return np.where(mask, np.nan, np.ma.getdata(values).astype(np.float64))
    cells = np.ma.getdata(values).astype(object)
    cells[mask] = None
    return cells


def _array(name, values):
    """What a table holds under a name, as an array: no dimension where one value is that of all rows."""
    try:
        array = values.to_numpy() if hasattr(values, "to_numpy") else np.asanyarray(values)
    except UnicodeDecodeError as error:  # bytes among texts
        raise _no_text(name, error) from None
    except ValueError as error:  # a list of lists that are not equally long
        raise _input_error("'%s' is no array: %s" % (name, error), name) from error
    if array.dtype.kind == "c":
        raise _input_error("'%s' holds complex numbers" % name, name)
    if array.dtype.kind in "mM" and _parted(name)[1] == "_s":
        raise _input_error("'%s' holds dates, and not seconds" % name, name, "(%s) / np.timedelta64(1, 's')" % (
            "times" if array.dtype.kind == "m" else "times - times.min()"))
    if np.ma.isMaskedArray(array):
        array = _unmasked(array)
    array = np.asarray(array)
    is_value = array.dtype.kind != "O" or array.ndim > 0 or np.isscalar(array[()]) or _is_missing(array[()])
    if array.ndim > 2 or not is_value:
        raise _input_error("'%s' has %d dimensions" % (name, array.ndim) if is_value else
                           "'%s' is %s" % (name, type(values).__name__), name,
                           "an array or a list with one value per row, or one value for all rows")
    return array


_LARGEST_EXACT = 2**53  # of the integers that float64 holds, all of them


def _cells(name, column):
    """A column as float64, or as a list of texts: words, and integers of which float64 would lose digits"""
    is_long = column.dtype.kind in "iu" and ((column > _LARGEST_EXACT) | (column < -_LARGEST_EXACT)).any()
    if column.dtype.kind in "fiu" and not is_long:
        return np.asarray(column, dtype=np.float64)
    try:
        return [_text(value) for value in column]
    except UnicodeDecodeError as error:
        raise _no_text(name, error) from None


def _columns(name, array, rows):
    """[(name, float64 array or list of texts)] of what stands under one name; rows: of the table."""
    if array.ndim == 0:
        array = np.full(rows, array, dtype=array.dtype)
    stem, unit = _parted(name)
    if stem in _ISOTROPIC and unit and (array.ndim == 1 or array.shape[1] == 1):
        cells = _cells(name, array.reshape(len(array)))
        return [(axis + unit, cells) for axis in _WIDE[stem]]
    if array.ndim == 1:
        return [(name, _cells(name, array))]
    return [(single, _cells(single, column)) for single, column in _single_columns(name, array, rows)]


class Written:
    """The text of a table that the library has written."""

    def __init__(self, text):
        self.text = text


def source(table, name):
    """A path as text, anything with columns as (name, {column: values}), what was written as (name, text)."""
    if isinstance(table, (str, os.PathLike)):
        return path_text(table, name)
    if isinstance(table, Written):
        return (name, table.text)
    if not hasattr(table, "keys"):
        raise _input_error("%s: a path, a pandas frame or a mapping of columns is expected, not %s"
                           % (name, type(table).__name__), name)
    arrays = {str(key): _array(str(key), table[key]) for key in table.keys()}
    # Columns of one value per row state how many rows there are; where there are none, arrays of several columns do.
    lengths = [len(array) for array in sorted((a for a in arrays.values() if a.ndim > 0), key=lambda a: a.ndim)]
    if arrays and not lengths:
        raise _input_error("%s: no column states how many rows there are" % name, next(iter(arrays)),
                           "a value that is no array or list is that of all rows")
    columns = {}
    for key, array in arrays.items():
        for single, values in _columns(key, array, lengths[0]):
            if single in columns:
                raise _input_error("column '%s' is given twice" % single, single)
            columns[single] = values
    return (name, columns)


def sources(tables, name):
    """One table, or a list of them."""
    if isinstance(tables, (list, tuple)):
        return [source(table, "%s[%d]" % (name, i)) for i, table in enumerate(tables)]
    return [source(tables, name)]


# As the library writes numbers: no sign, zero or blank that a number would lose.
_NUMBER = re.compile(r"-?(0|[1-9][0-9]*)(\.[0-9]*[1-9])?(e[+-][0-9]{2,3})?")


def _is_number(text):
    """Whether nothing of the text is lost where it is read as a number."""
    return _NUMBER.fullmatch(text) is not None and decimal.Decimal(repr(float(text))) == decimal.Decimal(text)


def _numbers_or_texts(column):
    """A column of whose name nothing says what it holds: numbers where every cell is one, else the texts; whole numbers
    that no int64 holds stay texts too."""
    cells = column.dropna()
    if not all(_is_number(text) for text in cells.unique()):
        return column
    is_whole = len(cells) == len(column) and cells.str.fullmatch("-?[0-9]+").all()
    if is_whole and any(abs(int(text)) >= 2**63 for text in cells.unique()):
        return column
    return column.map(int if is_whole else float, na_action="ignore").astype("int64" if is_whole else "float64")


def frame(csv):
    """A pandas frame of a file that the library writes: numbers to the last digit, texts to the last letter."""
    import pandas
    header = pandas.read_csv(io.StringIO(csv), comment=None, dtype=str, nrows=0).columns
    texts = [name for name in header if name in _TEXTS]
    others = [name for name in header if name not in _TEXTS and _parted(name)[1][1:] not in _UNITS]
    found = pandas.read_csv(io.StringIO(csv), float_precision="round_trip", comment=None,
                            dtype=dict.fromkeys(texts + others, str), keep_default_na=False, na_values=[""])
    for name in texts + others if "'" in csv else ():
        found[name] = found[name].map(_unguarded, na_action="ignore")
    for name in others:
        found[name] = _numbers_or_texts(found[name])
    return found
