#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the seeds: small cages as OBJ and in the bytes that fuzz_mesh.c reads. Run it again after changing either."""
import os

HERE = os.path.dirname(os.path.abspath(__file__))

TETRAHEDRON = (4, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
CUBE = (8, [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])


def torus(n, m):
    faces = []
    for i in range(n):
        for j in range(m):
            k, l = (i + 1) % n, (j + 1) % m
            faces.append([i * m + j, k * m + j, k * m + l, i * m + l])
    return n * m, faces


def prism(n):
    sides = [[k, (k + 1) % n, n + (k + 1) % n, n + k] for k in range(n)]
    return 2 * n, [list(range(n - 1, -1, -1)), list(range(n, 2 * n))] + sides


def kites(n):
    faces = []
    for k in range(2 * n):
        a, b = (k - 1) % (2 * n), (k + 1) % (2 * n)
        faces.append([2 * n, a, k, b] if k % 2 == 0 else [2 * n + 1, b, k, a])
    return 2 * n + 2, faces


def write(folder, name, data):
    os.makedirs(os.path.join(HERE, folder), exist_ok=True)
    with open(os.path.join(HERE, folder, name), 'wb') as file:
        file.write(data)


def obj(cage):
    n, faces = cage
    lines = ['v %d %d %d' % (i * i % 7 - 3, i * 5 % 11 - 5, i * 3 % 5 - 2) for i in range(n)]
    lines += ['f ' + ' '.join(str(v + 1) for v in face) for face in faces]
    return '\n'.join(lines).encode() + b'\n'


def packed(cage, surface, term, moves=()):
    n, faces = cage
    head = [n, len(faces), surface, term] + [len(face) for face in faces]
    return bytes(head + [v for face in faces for v in face] + list(moves))


def main():
    cages = {'tetrahedron': TETRAHEDRON, 'cube': CUBE, 'torus': torus(5, 4), 'prism': prism(5), 'kites': kites(5)}
    for name, cage in cages.items():
        write('corpus_obj', name, obj(cage))
        for surface in range(1, 4):
            write('corpus_mesh', '%s_%d' % (name, surface), packed(cage, surface, 0 if surface == 1 else surface - 1))
    write('corpus_pins', 'all_kinds', b'0 # stays\n3 line 0 0 2\n\n5 plane 1.5 -2e3 0\n')
    write('corpus_pins', 'weights', b'0 0.5\n3 line 0 0 2 .25 # softly\n5 plane 1 0 0 1\n')
    write('corpus_pins', 'no_vertex', b'# nothing\n')
    write('corpus_pins', 'no_number', b'1\nline 0 0 1\n')
    write('corpus_through', 'all_kinds', b'[{"vertex": 5, "at": [0, 0, 1.5e0], "normal": [0, -0, 1]},\n'
          b' {"face": 1, "uv": [0.25, 0.5], "corner": 0, "at": "here", "plane": [1, 0, 0]},\n'
          b' {"vertex": 3, "line": [1, 0, 0], "tangent": {"to": 7, "along": [0, 1, 0]}},\n'
          b' {"face": 2, "uv": [1, 0.5E-1], "tangent": {"to": "v", "along": [0, 1, 0]}}]')
    write('corpus_through', 'escapes', b'[{"\\u0076ertex": 1, "at": "h\\u0065re"}, {"a\\ud83d\\ude00\\n\\"": [true, false, null]}]')
    write('corpus_through', 'weights', b'[{"vertex": 1, "at": [0, 0, 1], "weight": 0.25}, {"vertex": 2, "at": "here", "weight": 1},\n'
          b' {"face": 1, "uv": [0.5, 0.5], "normal": [0, 0, 1], "weight": 0}]')
    write('corpus_through', 'chains', b'{"points": [{"vertex": 1, "at": "here"}], "chains": [\n'
          b' {"vertices": [0, 1, 2, 3], "closed": true, "curve": [[1, 0, 0], [0, 1e0, 0], [-1, 0, 0]], "curve_closed": true},\n'
          b' {"vertices": [5, 6], "closed": false, "curve": [[0, 0, 0], [1, 1, 1]], "parameters": [0.25, 1]}]}')
    write('corpus_through', 'curvatures', b'[{"face": 1, "uv": [0.5, 0.25], "at": "here", "normal": [0, 0, 1], "curvatures": [2, -5e-1],\n'
          b' "curvature_direction": [1, 0, 0]}, {"vertex": 3, "normal": [0, 1, 0], "curvatures": [1, 1]}]')
    write('corpus_through', 'deep', b'[' * 20 + b'1' + b']' * 20)
    write('corpus_through', 'wrong', b'{"vertex": 1, "vertex": 01.}')
    write('corpus_mesh', 'open', packed((8, CUBE[1][:5]), 1, 0))
    write('corpus_mesh', 'two_fans', packed((7, TETRAHEDRON[1] + [[0 if v == 0 else v + 3 for v in f]
                                                                   for f in TETRAHEDRON[1]]), 1, 0))
    write('corpus_mesh', 'moved', packed(CUBE, 3, 2, [5, 17, 99, 3, 0, 250]))
    write('corpus_mesh', 'not_finite', packed(CUBE, 1, 0, [0, 0, 255]))
    write('corpus_mesh', 'huge', packed(CUBE, 1, 0, [254] * 24))
    write('corpus_obj', 'words', b'# c\nmtllib m\no a\ng b\ns 1\nv 1e3 -2.5E-7 .5\\\n 1\nvt 0 0\nvn 0 0 1\n'
          b'v nan inf -inf\nv 0x1p3 1 2\nusemtl x\nf 1/1/1 2//1 3/2\nf -1 -2 -3\n')
    write('corpus_obj', 'bad_index', b'v 0 0 0\nf 1 2 99999999999999999999\nf 0 -9 x\n')
    write('corpus_obj', 'empty', b'')
    write('corpus_obj', 'binary', bytes(range(256)))
    api_corpus()
    write('corpus_options', 'defaults', bytes([255, 0]))
    write('corpus_options', 'old', bytes([10, 0]) + b'gauss_newton')
    write('corpus_options', 'members', bytes([255, 3] + [8] + 8 * [64] + [20] + 8 * [63] + [40] + 8 * [255]))
    write('corpus_options', 'name', b'willmore')


def api_corpus():
    """One seed for each call on each kind of cage, and one of all calls on each; then what surfaces there are."""
    plain = [0, 0] + [1, 1, 1]  # nobody moved, nothing cut off; no creases, no corners, smooth boundary
    calls = {'copies': 0, 'refine': 1, 'sampler': 2, 'measure': 3, 'minimize': 4, 'part': 5, 'mesh_part': 6, 'evaluate': 7,
             'solver': 9}
    for kind, shape in enumerate(('grid', 'tube', 'torus', 'prism', 'pyramid')):
        for name, call in calls.items():
            options = [kind % 4, 1, kind] + 16 * [0]
            write('corpus_api', '%s_%s' % (shape, name), bytes([kind, 1, 0] + plain + options + [call] + 12 * [kind + 1]))
        write('corpus_api', shape + '_all', bytes([kind, 2, 1] + plain + [0, 1, 0] + 16 * [0] + list(range(8))))
    creased = [0, 0] + [0, 3, 0, 200, 4, 30, 8, 17] + [0, 2, 1, 255, 3, 20, 1]
    write('corpus_api', 'creased', bytes([3, 1, 0] + creased + [0, 1, 0] + 16 * [0] + [0, 1, 7, 4, 0, 0]))
    write('corpus_api', 'heavy', bytes([3, 5, 0] + [2, 0, 3, 1, 5, 3, 0, 0] + [1, 1, 1] + [3, 1, 4, 7] + 15 * [0] + [7, 4]))


if __name__ == '__main__':
    main()
