#!/usr/bin/env python3
"""Keeps the arrows of ARCHITECTURE.md true: tools -> estimator -> problems -> models.

Fails on an #include or a CMake link against the arrows, and on a library that
the layer may not use. The generator of hidden effects, which must not share code
with what it tests, may use none of the layers. Standard library only.

usage: layering_test.py [ROOT]        check the tree (default: the one this file is in)
       layering_test.py --self-test   prove that planted violations are found
"""
import pathlib
import re
import sys
import tempfile

LAYERS = ['models', 'problems', 'estimator', 'tools']  # each may use those before it
FACES = {'python': 'tools'}  # another face next to tools/: what it may use is what tools/ may, but not tools/
SHOWN = 'tools/report'  # but for sentences and pictures, which both faces show; its library is sagitta_report
EXAMPLES = 'tools/examples'  # programs of somebody else: <sagitta/sagitta.h> and nothing of the tree

# Folders of estimator/: each may use those before it. Files of estimator/ itself (the front door) may use all.
ROOMS = ['statistics', 'least_squares', 'alignment', 'estimate', 'noise', 'calibration', 'baselines', 'intervals',
         'compensation', 'planning', 'agreement', 'inspection', 'validation', 'random_effects', 'explanations', 'evidence', 'diagnosis',
         'results', 'changes']

# Sentences of all rooms: a file ROOM_…words of this folder may use what that room may, and who may use the room may use it.
WORDS = 'report'

# Libraries a layer may include and link. What reads files (yaml-cpp, urdfdom, expat) and OpenSSL stay behind problems/.
LIBRARIES = {
    'models': {'Eigen', 'hwy'},
    'problems': {'Eigen', 'yaml-cpp', 'nlohmann', 'openssl', 'fmt', 'posix', 'urdfdom', 'console_bridge', 'expat'},
    'estimator': {'Eigen', 'nlohmann', 'ceres', 'glog', 'fmt', 'boost', 'hwy', 'fcl', 'posix'},
    'tools': {'Eigen', 'nlohmann', 'ceres', 'glog', 'gflags', 'fmt', 'posix'},
    'python': {'Eigen', 'nlohmann', 'glog', 'pybind11'},
}
LIBRARY_OF_LINK = {
    'Eigen3::Eigen': 'Eigen', 'yaml-cpp': 'yaml-cpp', 'yaml-cpp::yaml-cpp': 'yaml-cpp',
    'nlohmann_json::nlohmann_json': 'nlohmann', 'OpenSSL::Crypto': 'openssl',
    'urdfdom::urdfdom_model': 'urdfdom', 'console_bridge::console_bridge': 'console_bridge', 'EXPAT::EXPAT': 'expat',
    'Ceres::ceres': 'ceres', 'hwy': 'hwy', 'fcl': 'fcl', 'glog::glog': 'glog', 'gflags': 'gflags', 'fmt::fmt': 'fmt', 'Boost::boost': 'boost',
}
LAYER_OF_LINK = {'sagitta_' + layer: layer for layer in LAYERS} | {'sagitta::sagitta': 'estimator',
                                                                  'sagitta_face': 'tools', 'sagitta_report': 'tools', 'sagitta_reproduction': 'tools'}
# Apart from everything: the generator of cases in which an effect is hidden.
GENERATOR = 'tests/hidden_effects/generator'
GENERATOR_TARGET = 'sagitta_hidden_generator'
GENERATOR_LIBRARIES = {'Eigen', 'nlohmann'}
FREE_LINKS = {'PUBLIC', 'PRIVATE', 'INTERFACE', 'sagitta_warnings', '$<BUILD_INTERFACE:sagitta_warnings>', 'Threads::Threads'}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.MULTILINE)
LINK = re.compile(r'target_link_libraries\s*\(\s*(\S+)([^)]*)\)')


def library_of(header):
    """The library an angle-bracket header belongs to; None: the standard library."""
    if re.fullmatch(r'[a-z0-9_]+', header):
        return None
    if header.startswith(('Eigen/', 'unsupported/Eigen/')):
        return 'Eigen'
    if re.fullmatch(r'sys/\w+\.h|unistd\.h|fcntl\.h|iconv\.h|malloc\.h|pthread\.h', header):
        return 'posix'
    if header.startswith(('urdf_parser/', 'urdf_model/')):
        return 'urdfdom'
    if header == 'expat.h':
        return 'expat'
    return header.split('/')[0]


def why_not(layer, used_layer):
    """Empty when `layer` may use `used_layer`."""
    if layer in FACES:
        if used_layer == layer:
            return ''
        return '%s/ may not use tools/' % layer if used_layer == FACES[layer] else why_not(FACES[layer], used_layer)
    if used_layer in FACES:
        return '%s/ may not use %s/' % (layer, used_layer)
    if used_layer not in LAYERS:
        return "'%s' is no layer; write includes from the root of the tree" % used_layer
    if LAYERS.index(used_layer) > LAYERS.index(layer):
        return '%s/ may not use %s/' % (layer, used_layer)
    return ''


def why_not_room(path, header):
    """Empty when a file of estimator/ may use this header of estimator/."""
    own, used = path.split('/'), header.split('/')
    if own[0] != 'estimator' or used[0] != 'estimator' or len(own) < 3:
        return ''
    if len(used) < 3:
        return 'estimator/%s/ may not use the front door %s' % (own[1], header)
    own_room, used_room = room_of(own), room_of(used)
    for room in (own_room, used_room):
        if room not in ROOMS:
            return "'estimator/%s' is no room: add it to ROOMS of tests/layering_test.py" % room
    if ROOMS.index(used_room) > ROOMS.index(own_room):
        return 'estimator/%s/ may not use estimator/%s/' % (own_room, used_room)
    return ''


def room_of(parts):
    """The room of a file of estimator/; of a file of sentences the one that its name begins with."""
    if parts[1] != WORDS:
        return parts[1]
    for room in sorted(ROOMS, key=len, reverse=True):
        if re.fullmatch(room + r'_(\w+_)?words\.(h|cc)', parts[2]):
            return room
    return '/'.join(parts[1:])


def violations_of_source(layer, text, path=''):
    if path.startswith(EXAMPLES + '/'):
        yield from violations_of_example(text)
        return
    for match in INCLUDE.finditer(text):
        bracket, header = match.groups()
        line = text.count('\n', 0, match.start()) + 1
        if bracket == '"' and layer in FACES and header.startswith(SHOWN + '/'):
            reason = ''
        elif bracket == '"':
            reason = why_not(layer, header.split('/')[0]) or why_not_room(path, header)
        else:
            library = library_of(header)
            allowed = library is None or library in LIBRARIES[layer]
            reason = '' if allowed else '%s/ may not use <%s>' % (layer, header)
        if reason:
            yield line, reason


def violations_of_example(text):
    for match in INCLUDE.finditer(text):
        bracket, header = match.groups()
        if bracket == '"' or (library_of(header) is not None and header != 'sagitta/sagitta.h'):
            yield text.count('\n', 0, match.start()) + 1, 'an example may not use %s' % header


def violations_of_cmake(layer, text, path=''):
    text = re.sub(r'#.*', '', text)
    for match in LINK.finditer(text):
        line = text.count('\n', 0, match.start()) + 1
        for item in match.group(2).split():
            if item in FREE_LINKS or (item == 'sagitta_report' and layer in FACES):
                continue
            if item in LAYER_OF_LINK:
                reason = why_not(layer, LAYER_OF_LINK[item])
            elif LIBRARY_OF_LINK.get(item) in LIBRARIES[layer]:
                reason = ''
            else:
                reason = '%s/ may not link %s' % (layer, item)
            if reason:
                yield line, reason


def violations_of_generator_source(text):
    for match in INCLUDE.finditer(text):
        bracket, header = match.groups()
        line = text.count('\n', 0, match.start()) + 1
        if bracket == '"' and not header.startswith(GENERATOR + '/'):
            yield line, 'the generator may not use "%s"' % header
        elif bracket == '<' and library_of(header) not in {None} | GENERATOR_LIBRARIES:
            yield line, 'the generator may not use <%s>' % header


def violations_of_generator_links(text):
    text = re.sub(r'#.*', '', text)
    for match in LINK.finditer(text):
        if match.group(1) != GENERATOR_TARGET:
            continue
        line = text.count('\n', 0, match.start()) + 1
        for item in match.group(2).split():
            if item not in FREE_LINKS and LIBRARY_OF_LINK.get(item) not in GENERATOR_LIBRARIES:
                yield line, 'the generator may not link %s' % item


def generator_violations(root):
    checks = [(sorted((root / GENERATOR).rglob('*.h')) + sorted((root / GENERATOR).rglob('*.cc')),
               violations_of_generator_source),
              (sorted((root / GENERATOR).parent.rglob('CMakeLists.txt')), violations_of_generator_links)]
    for files, check in checks:
        if not files:
            yield '%s/: no sources or no CMakeLists.txt; nothing was checked' % GENERATOR
        for path in files:
            for line, reason in check(path.read_text(encoding='utf-8')):
                yield '%s:%d: %s' % (path.relative_to(root), line, reason)


def violations(root):
    found = list(generator_violations(root))
    for layer in LAYERS + sorted(FACES):
        sources = sorted(p for p in (root / layer).rglob('*') if p.suffix in ('.h', '.cc'))
        cmakes = sorted((root / layer).rglob('CMakeLists.txt'))
        if not sources or not cmakes:
            found.append('%s/: no sources or no CMakeLists.txt; nothing was checked' % layer)
        for files, check in ((sources, violations_of_source), (cmakes, violations_of_cmake)):
            for path in files:
                for line, reason in check(layer, path.read_text(encoding='utf-8'), path.relative_to(root).as_posix()):
                    found.append('%s:%d: %s' % (path.relative_to(root), line, reason))
    return found


PLANTED = [  # (file, text, what the message must say; None: no violation)
    ('models/a.h', '#include <cmath>\n#include <Eigen/Core>\n#include "models/b.h"\n', None),
    ('models/a.h', '#include "problems/b.h"\n', 'models/a.h:1: models/ may not use problems/'),
    ('models/a.h', '\n #  include "estimator/b.h"\n', 'models/a.h:2: models/ may not use estimator/'),
    ('models/a.h', '#include <ceres/jet.h>\n', 'models/ may not use <ceres/jet.h>'),
    ('models/a.h', '#include <unistd.h>\n', 'models/ may not use <unistd.h>'),
    ('models/a.h', '#include "tests/support/b.h"\n', "'tests' is no layer"),
    ('models/a.h', '#include "b.h"\n', "'b.h' is no layer"),
    ('models/a.h', '#include "../problems/b.h"\n', "'..' is no layer"),
    ('models/sub/a.cc', '#include <gflags/gflags.h>\n', 'models/sub/a.cc:1'),
    ('problems/a.cc', '#include "models/b.h"\n#include <yaml-cpp/yaml.h>\n#include <openssl/evp.h>\n', None),
    ('problems/a.cc', '#include <glog/logging.h>\n', 'problems/ may not use <glog/logging.h>'),
    ('problems/a.cc', '#include "tools/b.h"\n', 'problems/ may not use tools/'),
    ('estimator/noise/a.cc', '#include "estimator/statistics/b.h"\n', None),
    ('estimator/noise/a.cc', '#include "estimator/diagnosis/b.h"\n', 'may not use estimator/diagnosis/'),
    ('estimator/noise/a.cc', '#include "estimator/sagitta.h"\n', 'may not use the front door'),
    ('estimator/noise/a.cc', '#include "estimator/report/noise_words.h"\n', None),
    ('estimator/noise/a.cc', '#include "estimator/report/diagnosis_gap_words.h"\n', 'may not use estimator/diagnosis/'),
    ('estimator/report/noise_words.cc', '#include "estimator/diagnosis/b.h"\n', 'may not use estimator/diagnosis/'),
    ('estimator/report/least_squares_words.h', '#include "estimator/statistics/b.h"\n', None),
    ('estimator/report/else_words.cc', '#include "estimator/statistics/b.h"\n', 'is no room'),
    ('estimator/loft/a.cc', '#include "estimator/noise/b.h"\n', "is no room"),
    ('estimator/a.cc', '#include "problems/b.h"\n#include <ceres/ceres.h>\n', None),
    ('estimator/a.cc', '#include "tools/b.h"\n', 'estimator/ may not use tools/'),
    ('estimator/a.cc', '#include <gflags/gflags.h>\n', 'estimator/ may not use <gflags/gflags.h>'),
    ('estimator/a.cc', '#include <yaml-cpp/yaml.h>\n', 'estimator/ may not use <yaml-cpp/yaml.h>'),
    ('tools/a.cc', '#include "estimator/b.h"\n#include <gflags/gflags.h>\n', None),
    ('python/a.cc', '#include "estimator/b.h"\n#include "python/b.h"\n#include <pybind11/stl.h>\n', None),
    ('python/a.cc', '#include "tools/b.h"\n', 'python/ may not use tools/'),
    ('python/a.cc', '#include "tools/report/b.h"\n', None),
    ('estimator/a.cc', '#include "tools/report/b.h"\n', 'estimator/ may not use tools/'),
    ('tools/a.cc', '#include "python/b.h"\n', 'tools/ may not use python/'),
    ('tools/a.cc', '#include <pybind11/stl.h>\n', 'tools/ may not use <pybind11/stl.h>'),
    ('tools/examples/a.cc', '#include <sagitta/sagitta.h>\n#include <vector>\n', None),
    ('tools/examples/a.cc', '#include "estimator/sagitta.h"\n', 'an example may not use estimator/sagitta.h'),
    ('tools/a.cc', '#include <boost/any.hpp>\n', 'tools/ may not use <boost/any.hpp>'),
    ('models/CMakeLists.txt', 'target_link_libraries(sagitta_models\n PUBLIC Eigen3::Eigen)\n', None),
    ('models/CMakeLists.txt', 'target_link_libraries(m PUBLIC sagitta_problems)\n', 'models/ may not use problems/'),
    ('models/CMakeLists.txt', 'target_link_libraries(m PUBLIC\n Ceres::ceres)\n', 'models/ may not link Ceres::ceres'),
    ('problems/CMakeLists.txt', 'target_link_libraries(p PUBLIC sagitta::sagitta)\n', 'may not use estimator/'),
    (GENERATOR + '/a.cc', '#include <Eigen/Core>\n#include <cmath>\n#include "%s/b.h"\n' % GENERATOR, None),
    (GENERATOR + '/a.cc', '#include "models/chain.h"\n', 'may not use "models/chain.h"'),
    (GENERATOR + '/a.h', '#include "tests/support/arms.h"\n', 'may not use "tests/support/arms.h"'),
    (GENERATOR + '/a.cc', '#include <ceres/ceres.h>\n', 'may not use <ceres/ceres.h>'),
    ('tests/hidden_effects/CMakeLists.txt',
     'target_link_libraries(sagitta_hidden_generator PRIVATE Eigen3::Eigen sagitta_problems)\n',
     'may not link sagitta_problems'),
    ('estimator/CMakeLists.txt', '# target_link_libraries(e PUBLIC sagitta_tools)\n', None),
]


def self_test():
    wrong = 0
    for file, text, expected in PLANTED:
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for layer in LAYERS + sorted(FACES) + [GENERATOR]:
                (root / layer).mkdir(parents=True)
                (root / layer / 'clean.h').write_text('#include <vector>\n')
                (root / layer / 'CMakeLists.txt').write_text('')
            (root / file).parent.mkdir(exist_ok=True)
            (root / file).write_text(text)
            found = violations(root)
        good = not found if expected is None else len(found) == 1 and expected in found[0]
        if not good:
            wrong += 1
            print('FAIL  %s %r: expected %r, found %r' % (file, text, expected, found))
    with tempfile.TemporaryDirectory() as folder:
        if len(violations(pathlib.Path(folder))) != len(LAYERS) + len(FACES) + 2:
            wrong += 1
            print('FAIL  an empty tree passes')
    print('%d planted cases, %d wrong' % (len(PLANTED) + 1, wrong))
    return wrong


def main(arguments):
    if arguments == ['--self-test']:
        return 1 if self_test() else 0
    root = pathlib.Path(arguments[0] if arguments else pathlib.Path(__file__).parent.parent)
    found = violations(root.resolve())
    print('\n'.join(found) if found else 'the arrows hold')
    return 1 if found else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
