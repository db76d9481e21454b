// SPDX-License-Identifier: GPL-3.0-or-later
// Evaluates a Catmull-Clark cage with OpenSubdiv, in double: the tests' second opinion.
//
//   g++ -O2 -std=c++14 osd_eval.cpp -o osd_eval -losdCPU
//   osd_eval CAGE.obj [--creases FILE] [--boundary all|corners] [--level N]
//   osd_eval CAGE.obj --refine N [the same]    N uniform subdivisions instead: x y z of every vertex
//
// Reads and writes doubles of this machine's bytes. Input: face, corner, u, v of each point, conventions of
// curvopt_sampler_jets. Each gives 18 numbers, x y z of the point, of its derivatives by u, v, uu, uv, vv; then every vertex of
// the cage gives x y z nx ny nz: limit position and unit limit normal.
// Creases: lines "e a b sharpness" and "v a sharpness", vertices from 0. OBJ: v and f lines only, f with plain indices.
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/ptexIndices.h>
#include <opensubdiv/far/stencilTable.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

using namespace OpenSubdiv;

struct Point {
    double x[3];
    void Clear(void * = nullptr) { x[0] = x[1] = x[2] = 0; }
    void AddWithWeight(Point const &p, double w) {
        for (int i = 0; i < 3; ++i) x[i] += w * p.x[i];
    }
};

struct Cage {
    std::vector<Point> points;
    std::vector<int> sizes, corners;
    std::vector<int> crease_pairs, sharp_vertices;
    std::vector<float> crease_sharpness, vertex_sharpness;
};

static void fail(std::string const &what) {
    std::fprintf(stderr, "osd_eval: %s\n", what.c_str());
    std::exit(1);
}

static void read_obj(char const *path, Cage &cage) {
    std::ifstream in(path);
    if (!in) fail(std::string("cannot read ") + path);
    std::string line, word;
    while (std::getline(in, line)) {
        std::istringstream words(line);
        words >> word;
        if (line.compare(0, 2, "v ") == 0) {
            Point p;
            words >> p.x[0] >> p.x[1] >> p.x[2];
            cage.points.push_back(p);
        } else if (line.compare(0, 2, "f ") == 0) {
            int n = 0, index;
            for (; words >> index; ++n) cage.corners.push_back(index - 1);
            cage.sizes.push_back(n);
        }
    }
}

static void read_creases(char const *path, Cage &cage) {
    std::ifstream in(path);
    if (!in) fail(std::string("cannot read ") + path);
    std::string kind;
    int a, b;
    float s;
    while (in >> kind) {
        if (kind == "e" && in >> a >> b >> s) {
            cage.crease_pairs.push_back(a);
            cage.crease_pairs.push_back(b);
            cage.crease_sharpness.push_back(s);
        } else if (kind == "v" && in >> a >> s) {
            cage.sharp_vertices.push_back(a);
            cage.vertex_sharpness.push_back(s);
        } else
            fail("bad crease line");
    }
}

typedef std::unique_ptr<Far::TopologyRefiner> Refiner;

static Refiner make_refiner(Cage const &cage, bool corners) {
    Far::TopologyDescriptor d;
    d.numVertices = int(cage.points.size());
    d.numFaces = int(cage.sizes.size());
    d.numVertsPerFace = cage.sizes.data();
    d.vertIndicesPerFace = cage.corners.data();
    d.numCreases = int(cage.crease_sharpness.size());
    d.creaseVertexIndexPairs = cage.crease_pairs.data();
    d.creaseWeights = cage.crease_sharpness.data();
    d.numCorners = int(cage.sharp_vertices.size());
    d.cornerVertexIndices = cage.sharp_vertices.data();
    d.cornerWeights = cage.vertex_sharpness.data();
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(corners ? Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER
                                                : Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
    typedef Far::TopologyRefinerFactory<Far::TopologyDescriptor> Factory;
    Refiner refiner(Factory::Create(d, Factory::Options(Sdc::SCHEME_CATMARK, options)));
    if (!refiner) fail("OpenSubdiv refuses the cage");
    return refiner;
}

struct Location {
    int ptex;
    double u, v;
    double size;  // of Far's parameter in ours: Far scales derivatives by 2^depth; a quarter of an n-gon has depth 1
};

static std::vector<Location> read_points(Cage const &cage, Far::PtexIndices const &ptex) {
    std::vector<Location> out;
    double point[4];
    while (std::fread(point, sizeof point, 1, stdin) == 1) {
        int face = int(point[0]), corner = int(point[1]);
        if (face < 0 || face >= int(cage.sizes.size())) fail("face out of range");
        Location where = {ptex.GetFaceId(face) + (cage.sizes[face] == 4 ? 0 : corner), point[2], point[3],
                          cage.sizes[face] == 4 ? 1.0 : 0.5};
        out.push_back(where);
    }
    return out;
}

static void write(double x) {
    if (std::fwrite(&x, sizeof x, 1, stdout) != 1) fail("cannot write");
}

// Stencils of positions, first and second derivatives at every point; the adaptive refinement isolates to `level`.
static void write_points(Refiner const &refiner, Cage const &cage, std::vector<Location> const &where) {
    typedef Far::LimitStencilTableFactoryReal<double> Factory;
    Factory::LocationArrayVec arrays;
    for (Location const &at : where) {
        Factory::LocationArray one;
        one.ptexIdx = at.ptex;
        one.numLocations = 1;
        one.s = &at.u;
        one.t = &at.v;
        arrays.push_back(one);
    }
    Factory::Options options;
    options.generate1stDerivatives = true;
    options.generate2ndDerivatives = true;
    std::unique_ptr<Far::LimitStencilTableReal<double> const> table(
        Factory::Create(*refiner, arrays, nullptr, nullptr, options));
    if (!table || table->GetNumStencils() != int(where.size())) fail("a point was not found by OpenSubdiv");
    size_t n = where.size();
    std::vector<std::vector<Point>> jets(6, std::vector<Point>(n));
    table->UpdateValues(cage.points, jets[0]);
    table->UpdateDerivs(cage.points, jets[1], jets[2]);
    table->Update2ndDerivs(cage.points, jets[3], jets[4], jets[5]);
    for (size_t i = 0; i < n; ++i) {
        for (size_t k = 0; k < jets.size(); ++k) {
            double scale = k == 0 ? 1.0 : k < 3 ? where[i].size : where[i].size * where[i].size;
            for (double x : jets[k][i].x) write(scale * x);
        }
    }
}

// Limit positions and normals by the limit masks, at the vertices of the once refined cage that come from the cage.
static void write_vertices(Cage const &cage, bool corners) {
    Refiner refiner = make_refiner(cage, corners);
    Far::TopologyRefiner::UniformOptions options(1);
    options.fullTopologyInLastLevel = true;
    refiner->RefineUniform(options);
    Far::PrimvarRefinerReal<double> primvar(*refiner);
    size_t n = refiner->GetLevel(1).GetNumVertices();
    std::vector<Point> fine(n), limit(n), du(n), dv(n);
    primvar.Interpolate(1, cage.points, fine);
    primvar.Limit(fine, limit, du, dv);
    for (size_t i = 0; i < cage.points.size(); ++i) {
        int at = refiner->GetLevel(0).GetVertexChildVertex(int(i));
        double const *a = du[at].x, *b = dv[at].x;
        double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
        double size = std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
        for (double x : limit[at].x) write(x);
        for (double x : c) write(x / size);
    }
}

// Every vertex after so many subdivisions, whatever the cage's topology.
static void write_refined(Cage const &cage, bool corners, int levels) {
    Refiner refiner = make_refiner(cage, corners);
    Far::TopologyRefiner::UniformOptions options(levels);
    options.fullTopologyInLastLevel = true;
    refiner->RefineUniform(options);
    Far::PrimvarRefinerReal<double> primvar(*refiner);
    std::vector<Point> points = cage.points;
    for (int level = 1; level <= levels; ++level) {
        std::vector<Point> fine(refiner->GetLevel(level).GetNumVertices());
        primvar.Interpolate(level, points, fine);
        points.swap(fine);
    }
    for (Point const &p : points)
        for (double x : p.x) write(x);
}

int main(int argc, char **argv) {
    if (argc < 2) fail("usage: osd_eval CAGE.obj [--creases FILE] [--boundary all|corners] [--level N]");
    Cage cage;
    read_obj(argv[1], cage);
    bool corners = false;
    int level = 10, refine = 0;
    for (int i = 2; i < argc; i += 2) {
        std::string option = argv[i];
        if (i + 1 == argc) fail("option without value");
        if (option == "--creases")
            read_creases(argv[i + 1], cage);
        else if (option == "--boundary")
            corners = std::string(argv[i + 1]) == "corners";
        else if (option == "--refine")
            refine = std::atoi(argv[i + 1]);
        else if (option == "--level")
            level = std::atoi(argv[i + 1]);
        else
            fail("unknown option " + option);
    }
    if (refine > 0) {
        write_refined(cage, corners, refine);
        return 0;
    }
    Refiner refiner = make_refiner(cage, corners);
    refiner->RefineAdaptive(Far::TopologyRefiner::AdaptiveOptions(level));
    Far::PtexIndices ptex(*refiner);
    std::vector<Location> where = read_points(cage, ptex);
    if (!where.empty()) write_points(refiner, cage, where);
    write_vertices(cage, corners);
    return 0;
}
