# SPDX-License-Identifier: MIT
"""Sum JUnit logs into one line: N passed, N failed, N skipped.

usage: tally.py [--gates PASSED FAILED] FILE.xml ...
Missing files count as nothing; exit status 1 when something failed or nothing ran."""
import os
import sys
import xml.etree.ElementTree as ElementTree


def count(paths):
    passed = failed = skipped = 0
    for path in paths:
        if not os.path.exists(path):
            continue
        for case in ElementTree.parse(path).getroot().iter('testcase'):
            if case.find('failure') is not None or case.find('error') is not None:
                failed += 1
            elif case.find('skipped') is not None:
                skipped += 1
            else:
                passed += 1
    return passed, failed, skipped


def main(args):
    gates = (0, 0)
    if args[:1] == ['--gates']:
        gates = (int(args[1]), int(args[2]))
        args = args[3:]
    passed, failed, skipped = count(args)
    passed += gates[0]
    failed += gates[1]
    print(f'{passed} passed, {failed} failed, {skipped} skipped')
    return 1 if failed or passed == 0 else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
