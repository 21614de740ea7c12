// What OpenSubdiv takes for the meshes of `cargo bench --bench refine -- --tables`, one thread, CPU time in ms:
// - topology, adaptive refinement and patch table with Gregory end caps; no control point is computed (median and least of 21);
// - that and all control points, as our tables have them: places and colours (x, y, r, g, b, a in single precision) of the
//   refined vertices, level by level, and of the Gregory patches' own points (least of 21).
//
// c++ -O3 -o opensubdiv tests/bench/opensubdiv.cpp -losdCPU && ./opensubdiv
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>
#include <vector>

using namespace OpenSubdiv;

static double cpu_ms() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * t.tv_sec + 1e-6 * t.tv_nsec;
}

// Place and colour.
struct Value {
    float x[6];
    void Clear(void * = nullptr) { std::fill(x, x + 6, 0.0f); }
    void AddWithWeight(const Value &v, float w) {
        for (int i = 0; i < 6; ++i) {
            x[i] += w * v.x[i];
        }
    }
};

// n x n quads, every step-th of them cut into two triangles.
static void mixed(int n, int step, std::vector<int> &sizes, std::vector<int> &corners) {
    for (int f = 0; f < n * n; ++f) {
        int v = (f / n) * (n + 1) + f % n;
        int q[4] = {v, v + 1, v + n + 2, v + n + 1};
        if (f % step == 0) {
            sizes.insert(sizes.end(), {3, 3});
            corners.insert(corners.end(), {q[0], q[1], q[2], q[0], q[2], q[3]});
        } else {
            sizes.push_back(4);
            corners.insert(corners.end(), q, q + 4);
        }
    }
}

// With an argument only the mesh of so many faces.
int main(int arguments, char **argument) {
    struct Mesh {
        int n, step;
    };
    for (Mesh mesh : {Mesh{24, 7}, Mesh{38, 11}, Mesh{100, 1 << 30}}) {
        std::vector<int> sizes, corners;
        mixed(mesh.n, mesh.step, sizes, corners);
        if (arguments > 1 && int(sizes.size()) != std::atoi(argument[1])) {
            continue;
        }
        Far::TopologyDescriptor topology;
        topology.numVertices = (mesh.n + 1) * (mesh.n + 1);
        topology.numFaces = int(sizes.size());
        topology.numVertsPerFace = sizes.data();
        topology.vertIndicesPerFace = corners.data();
        Sdc::Options scheme;
        scheme.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
        using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
        for (int level : {1, 2, 3, 4, 5, 6, 8}) {
            std::vector<double> times, whole;
            std::vector<Value> values;
            int patches = 0, gregory = 0;
            for (int run = 0; run < 21; ++run) {
                double start = cpu_ms();
                std::unique_ptr<Far::TopologyRefiner> refiner(
                    Factory::Create(topology, Factory::Options(Sdc::SCHEME_CATMARK, scheme)));
                Far::TopologyRefiner::AdaptiveOptions adaptive(level);
                refiner->RefineAdaptive(adaptive);
                Far::PatchTableFactory::Options options(level);
                options.SetEndCapType(Far::PatchTableFactory::Options::ENDCAP_GREGORY_BASIS);
                std::unique_ptr<Far::PatchTable> table(Far::PatchTableFactory::Create(*refiner, options));
                times.push_back(cpu_ms() - start);
                values.resize(refiner->GetNumVerticesTotal() + table->GetNumLocalPoints());
                for (int v = 0; v < topology.numVertices; ++v) {
                    float i = float(v / (mesh.n + 1)), j = float(v % (mesh.n + 1));
                    values[v] = Value{{j, i, 1.0f, 1.0f, 1.0f, 1.0f}};
                }
                Far::PrimvarRefiner primvars(*refiner);
                Value *from = values.data();
                for (int l = 1; l <= refiner->GetMaxLevel(); ++l) {
                    Value *to = from + refiner->GetLevel(l - 1).GetNumVertices();
                    primvars.Interpolate(l, from, to);
                    from = to;
                }
                if (table->GetNumLocalPoints() > 0) {
                    table->ComputeLocalPointValues(values.data(), values.data() + refiner->GetNumVerticesTotal());
                }
                whole.push_back(cpu_ms() - start);
                patches = table->GetNumPatchesTotal();
                gregory = 0;
                for (int array = 0; array < table->GetNumPatchArrays(); ++array) {
                    if (table->GetPatchArrayDescriptor(array).GetType() == Far::PatchDescriptor::GREGORY_BASIS) {
                        gregory += table->GetNumPatches(array);
                    }
                }
            }
            std::sort(times.begin(), times.end());
            double ms = times[times.size() / 2];
            double all = *std::min_element(whole.begin(), whole.end());
            std::printf("%d faces, level %d: %d patches (%d Gregory), %.3f ms (least %.3f), %.0f patches/s",
                        int(sizes.size()), level, patches, gregory, ms, times[0], patches / ms * 1e3);
            std::printf("; with control points %.3f ms, %.3f times as long\n", all, all / times[0]);
        }
    }
}
