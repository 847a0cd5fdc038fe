#!/usr/bin/env python3
"""docs/tutorial/ holds what its script writes, byte for byte, from the published data."""
import pathlib
import subprocess
import sys
import tempfile

FOLDER = pathlib.Path(__file__).resolve().parent.parent / 'docs' / 'tutorial'
SCRIPT = FOLDER / 'make_tutorial_files.py'


def main():
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, str(SCRIPT), '--out', folder], check=True)
        written = sorted(pathlib.Path(folder).iterdir())
        differ = [path.name for path in written if path.read_bytes() != (FOLDER / path.name).read_bytes()]
    if differ or len(written) != 2:
        print('docs/tutorial: %s not as %s writes them' % (differ or written, SCRIPT.name))
        return 1
    print('the files of the tutorial are as their script writes them')
    return 0


if __name__ == '__main__':
    sys.exit(main())
