// What lack of memory leaves behind: each operation is tried with the first, the second, the third ... allocation failing,
// until it succeeds. Where it fails, the object is what it was, and the same operation then does as ever.
#include <insonify/insonify.hpp>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <new>

using namespace insonify;

namespace {

std::atomic<long> left{-1}; // allocations until one fails; below 0: none does

void* take(std::size_t size, std::size_t alignment) {
    if (left >= 0 && left-- == 0) throw std::bad_alloc{};
    void* const memory = alignment == 0 ? std::malloc(size == 0 ? 1 : size)
                                        : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
    if (memory == nullptr) throw std::bad_alloc{};
    return memory;
}

} // namespace

[[gnu::noinline]] void* operator new(std::size_t size) { return take(size, 0); }
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
    return take(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace {

int faults = 0;

/// All that a scene tells of itself, and what is traced in it.
struct portrait {
    bool built = false;
    std::vector<object> objects{};
    std::vector<medium> media{};
    aabb box{};
    scan_lines seen{};
};

portrait portrait_of(const scene& body) {
    portrait p;
    p.objects = body.objects();
    p.media.assign(body.media().begin(), body.media().end());
    p.box = body.box();
    p.built = body.is_built();
    try {
        p.seen = trace(exec::seq, body, linear_array{.lines = 16}, pose{}, law2011{}, {.depth = 40_mm},
                       straight_lines{line_search::slices});
        const scan_lines rays = trace(exec::seq, body, linear_array{.lines = 16}, pose{}, law2011{}, {.depth = 40_mm},
                                      straight_lines{line_search::rays});
        p.seen.values.insert(p.seen.values.end(), rays.values.begin(), rays.values.end());
    } catch (const usage_error&) {
    }
    return p;
}

bool same(const portrait& a, const portrait& b) {
    const auto same_object = [](const object& x, const object& y) {
        return x.id == y.id && x.name == y.name && x.at == y.at && x.surface.positions == y.surface.positions &&
               x.surface.faces == y.surface.faces && x.inside == y.inside && x.priority == y.priority;
    };
    return a.built == b.built && a.media == b.media && a.box.lower == b.box.lower && a.box.upper == b.box.upper &&
           a.seen == b.seen &&
           std::equal(a.objects.begin(), a.objects.end(), b.objects.begin(), b.objects.end(), same_object);
}

void report(const char* what, long failures, bool holds) {
    std::printf("%-46s %5ld allocations failed, one at a time: %s\n", what, failures, holds ? "as it was" : "CHANGED");
    if (!holds || failures == 0) ++faults;
}

/// @param operation  called with a copy of `body`
template <class Operation>
void check_scene(const char* what, const scene& body, const Operation& operation) {
    const portrait before = portrait_of(body);
    scene done = body;
    operation(done);
    const portrait after = portrait_of(done);
    bool holds = true;
    for (long n = 0;; ++n) {
        scene copy = body;
        left = n;
        bool failed = false;
        try {
            operation(copy);
        } catch (const std::bad_alloc&) {
            failed = true;
        }
        left = -1;
        if (failed) {
            holds = holds && same(portrait_of(copy), before);
            operation(copy);
        }
        holds = holds && same(portrait_of(copy), after);
        if (!failed) return report(what, n, holds);
    }
}

struct ball {
    vec3 centre{};
};
aabb bounds(const ball& b) { return {b.centre - 1.0F, b.centre + 1.0F}; }
hit intersect(const ray& r, const ball& b) {
    const vec3 from = r.origin - b.centre;
    const float along = dot(from, r.direction), squared = along * along - dot(from, from) + 1;
    hit found;
    if (squared >= 0) found.distance = -along - std::sqrt(squared);
    return found;
}

void check_tree() {
    std::vector<ball> balls(300);
    for (std::size_t i = 0; i < balls.size(); ++i) balls[i].centre = {static_cast<float>(3 * i), 0, 0};
    const auto hits_of = [&](const auto& tree) {
        std::vector<hit> hits;
        tree.all({.origin = {-10, 0, 0}, .direction = {1, 0, 0}}, hits);
        return hits;
    };
    bool holds = true;
    for (long n = 0;; ++n) {
        bvh tree{exec::seq, balls};
        const std::vector<hit> before = hits_of(tree);
        left = n;
        bool failed = false;
        try {
            tree.rebuild(exec::seq);
        } catch (const std::bad_alloc&) {
            failed = true;
        }
        left = -1;
        holds = holds && before.size() == balls.size() && hits_of(tree) == before;
        if (!failed) return report("bvh::rebuild", n, holds);
    }
}

/// A scanner that ran out of memory is as good as a new one.
void check_frame(const scene& body) {
    const linear_array probe{.lines = 16};
    const b_mode_settings settings{.depth = 20_mm, .samples = 512, .size = {32, 32}, .planes = 1};
    const image expected = b_mode(exec::seq, body, probe, pose{}, settings);
    bool holds = true;
    for (long n = 0;; ++n) {
        scanner<linear_array> machine{probe, settings};
        left = n;
        bool failed = false;
        try {
            machine.scan(exec::seq, body, pose{});
        } catch (const std::bad_alloc&) {
            failed = true;
        }
        left = -1;
        holds = holds && machine.scan(exec::seq, body, pose{}) == expected;
        if (!failed) return report("a scanner", n, holds);
    }
}

/// A file is read whole, or not at all.
void check_file() {
    const char* const path = "out_of_memory.obj";
    std::ofstream{path}
        << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\no a\nusemtl bone\nf 1 3 2\nf 1 2 4\nusemtl fat\nf 1 4 3 2\n";
    const portrait expected = portrait_of(load_obj_scene(path, {.unit = 1_mm}));
    bool holds = true;
    for (long n = 0;; ++n) {
        left = n;
        bool failed = false;
        try {
            const scene loaded = load_obj_scene(path, {.unit = 1_mm});
            left = -1;
            holds = holds && same(portrait_of(loaded), expected);
        } catch (const std::bad_alloc&) {
            failed = true;
        } catch (const io_error&) {
            failed = true;
        }
        left = -1;
        if (failed) continue;
        std::remove(path);
        return report("load_obj_scene", n, holds);
    }
}

} // namespace

#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>

int main() {
    scene body{tissue::muscle};
    const object_id first = body.add(make_sphere({0, 0, 20_mm}, 8_mm, 2), tissue::bone, {.name = "bone"});
    const object_id second = body.add(make_box({-5_mm, -5_mm, 5_mm}, {5_mm, 5_mm, 9_mm}), tissue::blood);
    const auto move = [&](scene& s) {
        for (const object_id id : {first, second})
            for (vec3& p : s.positions(id)) p.x += 1_mm;
    };
    check_scene("scene::build", body, [](scene& s) { s.build(exec::seq); });
    check_scene("scene::build, two threads", body, [](scene& s) { s.build(exec::par.threads(2)); });
    scene fine{tissue::fat};
    fine.add(make_sphere({0, 0, 20_mm}, 8_mm, 5), tissue::bone);
    check_scene("scene::build, parts of a tree on two threads", fine, [](scene& s) { s.build(exec::par.threads(2)); });
    scene built = body;
    built.build(exec::seq);
    scene more = built;
    more.add(make_sphere({0, 0, 30_mm}, 3_mm, 1), tissue::steel);
    check_scene("scene::build after add", more, [](scene& s) { s.build(exec::seq); });
    check_scene("scene::add", built, [](scene& s) {
        s.add(make_box({0, 0, 0}, {1_mm, 1_mm, 1_mm}), tissue::fat, {.name = "a name that is too long for no memory"});
    });
    scene moved = built;
    move(moved);
    check_scene("scene::update", moved, [](scene& s) { s.update(exec::seq); });
    scene updated = moved;
    updated.update(exec::seq);
    check_scene("scene::view_for_rays", updated, [](scene& s) { s.view_for_rays(exec::seq); });
    check_tree();
    check_frame(built);
    check_file();
    return faults == 0 ? 0 : 1;
}
