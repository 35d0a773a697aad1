#ifndef INSONIFY_GEOMETRY_REPAIR_HPP
#define INSONIFY_GEOMETRY_REPAIR_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/view.hpp>
#include <insonify/geometry/loop_filler.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/triangle.hpp>
#include <insonify/geometry/validate.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// How to mend a mesh.
struct repair_settings {
    float weld_distance = 1e-6F; ///< vertices of open edges that lie within it are merged, metres, 0 to 0.01
};

/// A mesh as `repair` returns it.
struct repaired_mesh {
    mesh surface{};                   ///< mended as far as the notes say
    std::vector<std::string> notes{}; ///< a sentence for each kind of thing that was done, or deliberately left
};

namespace detail {

/// What `repair` does, step by step. Sides of faces are numbered as the slots of half edges.
template <class Deferred = void>
class mesh_repair {
  public:
    mesh_repair(const mesh_view& given, const repair_settings& settings)
        : positions_(given.positions.begin(), given.positions.end()), faces_(given.faces.begin(), given.faces.end()) {
        weld_equal();
        weld_open_edges(settings.weld_distance);
        drop_copies();
        is_turned_.assign(faces_.size(), 0);
        connect();
        find_parts();
        if (!crowded_.empty()) {
            turn_closed_patches();
            pair_crowded_edges();
            find_parts();
        }
        close_holes();
        turn_outwards();
        drop_sheets();
        separate();
        drop_unused_vertices();
    }

    repaired_mesh result() && { return {{std::move(positions_), std::move(faces_)}, std::move(notes_)}; }

  private:
    static constexpr std::uint32_t none = ~0U, locked = ~0U - 1; // no other side; more than two that do not match
    // A part is a sheet where its volume over the area of its holes, once closed, is less than this fraction of the
    // radius of that area: a disc with a bulge of 10 %, or a flat box without a lid.
    static constexpr double min_thickness = 0.05;
    static constexpr double max_loose_area = 0.01; // fraction of the largest closed part; smaller sheets are removed

    struct part { // faces connected by pairs of sides
        bool is_one_sided = false, is_locked = false, is_open = false, is_cavity = false, is_dropped = false;
        std::uint32_t faces = 0;
        double volume = 0, area = 0;

        bool is_closed() const { return !is_one_sided && !is_locked && !is_open; }
        bool has_holes() const { return !is_one_sided && !is_locked && is_open; }
    };

    static std::uint32_t next_side(std::uint32_t slot) { return slot % 3 == 2 ? slot - 2 : slot + 1; }
    std::uint32_t from(std::uint32_t slot) const { return faces_[slot / 3][static_cast<int>(slot % 3)]; }
    std::uint32_t to(std::uint32_t slot) const { return from(next_side(slot)); }
    std::uint32_t opposite(std::uint32_t slot) const { return to(next_side(slot)); }
    bool is_upwards(std::uint32_t slot) const { return from(slot) < to(slot); }
    dvec3 at(std::uint32_t vertex) const { return dvec3{positions_[vertex]}; }
    part& part_at(std::uint32_t face) { return parts_[part_of_[face]]; }
    std::uint32_t add_vertex(vec3 point) {
        positions_.push_back(point);
        return static_cast<std::uint32_t>(positions_.size() - 1);
    }
    void join(std::uint32_t a, std::uint32_t b) {
        twins_[a] = b;
        twins_[b] = a;
    }

    // Adds a sentence on how many there are of something, if there are any.
    void note(const char* before, std::size_t count, const char* one, const char* many, const std::string& after) {
        if (count > 0) notes_.push_back(before + counted(count, one, many) + after);
    }

    void weld_equal() {
        std::vector<std::uint8_t> is_used(positions_.size(), 0);
        for (const uvec3& f : faces_) is_used[f.x] = is_used[f.y] = is_used[f.z] = 1;
        const auto unused = static_cast<std::size_t>(std::count(is_used.begin(), is_used.end(), 0));
        note("Removed ", unused, "vertex", "vertices", " without faces.");
        merge(is_used, 0, " with another one at the same point.");
    }

    // Other vertices stay: a closed surface may be finer than the distance.
    void weld_open_edges(float distance) {
        std::vector<std::uint8_t> is_open(positions_.size(), 0);
        for_each_edge(edges_, [&](view<const half_edge> sides) {
            if (sides.size() == 1) is_open[sides[0].lower()] = is_open[sides[0].upper()] = 1;
        });
        merge(is_open, static_cast<double>(distance),
              " of open edges with another one within " + number_text(1e3F * distance) + " mm.");
    }

    // Welds vertices, and removes the faces that lose a corner.
    void merge(const std::vector<std::uint8_t>& is_some, double within, const std::string& how) {
        const std::vector<std::uint32_t> number = weld(positions_, within, is_some);
        std::size_t merged = 0;
        for (std::uint32_t vertex = 0; vertex < number.size(); ++vertex) merged += number[vertex] != vertex ? 1 : 0;
        note("Merged ", merged, "vertex", "vertices", how);
        if (merged == 0 && !edges_.empty()) return; // the first time, there are no edges yet
        for (uvec3& f : faces_) f = {number[f.x], number[f.y], number[f.z]};
        const std::size_t lost =
            std::erase_if(faces_, [](const uvec3& f) { return f.x == f.y || f.y == f.z || f.z == f.x; });
        note("Removed ", lost, "face", "faces", " with two corners at the same point.");
        edges_ = sorted_edges(faces_);
    }

    // Keeps one of the faces with the same corners, and none of those that are a wall inside a body.
    void drop_copies() {
        std::vector<std::uint32_t> first(faces_.size()), copies(faces_.size(), 0);
        std::iota(first.begin(), first.end(), 0U);                   // face with the same corners
        std::vector<std::pair<std::uint32_t, std::uint32_t>> around; // of an edge: opposite vertex and face
        for_each_edge(edges_, [&](view<const half_edge> sides) {
            around.clear();
            for (const half_edge& side : sides) around.emplace_back(opposite(side.slot), side.slot / 3);
            std::sort(around.begin(), around.end());
            for (std::size_t i = 1; i < around.size(); ++i)
                if (around[i].first == around[i - 1].first) first[around[i].second] = first[around[i - 1].second];
        });
        for (const std::uint32_t face : first) ++copies[face];
        if (std::count(copies.begin(), copies.end(), 0U) == 0) return;

        // A patch of doubled faces is a wall where most of its borders have two other faces each, or four: at some, one
        // may be missing.
        disjoint_sets patches{faces_.size()};
        std::vector<std::int64_t> borders(faces_.size(), 0); // with an even number of others, less those with an odd
        for_each_edge(edges_, [&](view<const half_edge> sides) {
            const auto others = std::count_if(sides.begin(), sides.end(),
                                              [&](const half_edge& side) { return copies[side.slot / 3] == 1; });
            for (const half_edge& side : sides) {
                const std::uint32_t face = side.slot / 3;
                if (others == 0)
                    patches.join(sides[0].slot / 3, face);
                else if (copies[face] > 1)
                    borders[face] += others % 2 == 0 ? 1 : -1;
            }
        });
        for (std::uint32_t face = 0; face < faces_.size(); ++face)
            if (const std::uint32_t patch = patches.find(face); patch != face) borders[patch] += borders[face];
        std::size_t kept = 0, removed = 0, walls = 0;
        for (std::uint32_t face = 0; face < faces_.size(); ++face) {
            const bool is_wall = borders[patches.find(face)] > 0;
            if (copies[face] == 0) continue;
            (is_wall ? walls : removed) += copies[face] - (is_wall ? 0 : 1);
            if (!is_wall) faces_[kept++] = faces_[face];
        }
        faces_.resize(kept);
        edges_ = sorted_edges(faces_);
        note("Removed ", removed, "copy", "copies", " of faces.");
        note("Removed ", walls, "face", "faces", " of walls between parts that touch.");
    }

    // Pairs the two sides of each edge of two faces.
    void connect() {
        twins_.assign(3 * faces_.size(), none);
        crowded_.clear();
        for_each_edge(edges_, [&](view<const half_edge> sides) {
            if (sides.size() == 2) join(sides[0].slot, sides[1].slot);
            if (sides.size() <= 2) return;
            std::vector<std::uint32_t>& crowd = crowded_.emplace_back();
            for (const half_edge& side : sides) {
                crowd.push_back(side.slot);
                twins_[side.slot] = locked;
            }
        });
    }

    // Finds the parts, and turns the faces that differ from most of their part.
    void find_parts() {
        parts_.clear();
        part_of_.assign(faces_.size(), none);
        std::vector<std::uint8_t> differs(faces_.size(), 0); // from the first face of its part
        std::vector<std::uint32_t> members;
        for (std::uint32_t seed = 0; seed < faces_.size(); ++seed) {
            if (part_of_[seed] != none) continue;
            const auto number = static_cast<std::uint32_t>(parts_.size());
            part& own = parts_.emplace_back();
            std::size_t different = 0;
            members.assign(1, seed);
            part_of_[seed] = number;
            for (std::size_t i = 0; i < members.size(); ++i)
                for (std::uint32_t slot = 3 * members[i]; slot < 3 * members[i] + 3; ++slot) {
                    const std::uint32_t twin = twins_[slot], other = twin / 3;
                    own.is_open = own.is_open || twin == none;
                    own.is_locked = own.is_locked || twin == locked;
                    if (twin >= locked) continue;
                    const bool wanted = (differs[slot / 3] != 0) != (from(slot) == from(twin));
                    if (part_of_[other] == none) {
                        part_of_[other] = number;
                        differs[other] = wanted;
                        different += wanted ? 1 : 0;
                        members.push_back(other);
                    }
                    own.is_one_sided = own.is_one_sided || (differs[other] != 0) != wanted;
                }
            own.faces = static_cast<std::uint32_t>(members.size());
            const bool turn_others = 2 * different > members.size();
            for (const std::uint32_t face : members)
                differs[face] = !own.is_one_sided && (differs[face] != 0) != turn_others;
        }
        turn_faces([&](std::uint32_t face) { return differs[face] != 0; });
        for (std::uint32_t face = 0; face < faces_.size(); ++face) add_size(part_at(face), faces_[face]);
    }
    void add_size(part& own, const uvec3& face) const {
        const dvec3 a = at(face.x), area = cross(at(face.y) - a, at(face.z) - a);
        own.volume += dot(a - at(0), area) / 6;
        own.area += length(area) / 2;
    }

    // Swaps corners and sides of some faces.
    template <class IsTurned>
    void turn_faces(const IsTurned& is_turned) {
        const auto moved = [&](std::uint32_t slot) {
            return slot < locked && is_turned(slot / 3) ? slot + 2 - 2 * (slot % 3) : slot;
        };
        for (std::uint32_t face = 0; face < faces_.size(); ++face) {
            if (!is_turned(face)) continue;
            std::swap(faces_[face].y, faces_[face].z);
            std::swap(twins_[std::size_t{3} * face], twins_[std::size_t{3} * face + 2]);
            if (face < is_turned_.size()) is_turned_[face] ^= 1U;
        }
        for (std::uint32_t& twin : twins_) twin = moved(twin);
        for (std::vector<std::uint32_t>& sides : crowded_)
            for (std::uint32_t& slot : sides) slot = moved(slot);
    }

    // Patches, connected by edges of two faces, that are closed by themselves are turned outwards: pairing needs to
    // know where the body is.
    void turn_closed_patches() {
        for (const std::vector<std::uint32_t>& sides : crowded_)
            for (const std::uint32_t slot : sides) {
                part& own = part_at(slot / 3);
                int balance = 0;
                for (const std::uint32_t other : sides)
                    if (&part_at(other / 3) == &own) balance += is_upwards(other) ? 1 : -1;
                own.is_open = own.is_open || balance != 0;
            }
        turn_faces([&](std::uint32_t face) {
            const part& own = part_at(face);
            return !own.is_open && !own.is_one_sided && own.volume < 0;
        });
    }

    // Pairs the sides of edges of four faces and more, around each wedge of the body.
    void pair_crowded_edges() {
        for (const std::vector<std::uint32_t>& sides : crowded_) {
            const half_edge edge{from(sides[0]), to(sides[0]), 0};
            const dvec3 begin = at(edge.lower()), along = at(edge.upper()) - begin;
            const auto across = [&](std::uint32_t slot) {
                const dvec3 corner = at(opposite(slot)) - begin;
                return corner - (dot(corner, along) / dot(along, along)) * along;
            };
            const dvec3 zero = across(sides[0]);
            std::vector<std::pair<double, std::uint32_t>> spokes; // by their angle
            std::size_t upwards = 0;
            bool has_one_sided = false;
            for (const std::uint32_t slot : sides) {
                const dvec3 spoke = across(slot);
                spokes.emplace_back(std::atan2(dot(cross(zero, spoke), along) / length(along), dot(zero, spoke)), slot);
                upwards += is_upwards(slot) ? 1 : 0;
                has_one_sided = has_one_sided || part_at(slot / 3).is_one_sided;
            }
            if (2 * upwards != sides.size() || has_one_sided) continue;
            std::sort(spokes.begin(), spokes.end());
            std::vector<std::uint32_t> open; // downward sides, at which the body begins, are paired as brackets
            for (std::size_t turn = 0; turn < 2 * spokes.size(); ++turn) {
                const std::uint32_t slot = spokes[turn % spokes.size()].second;
                if (twins_[slot] != locked) continue;
                if (!is_upwards(slot) && turn < spokes.size()) {
                    open.push_back(slot);
                } else if (is_upwards(slot) && !open.empty()) {
                    join(open.back(), slot);
                    open.pop_back();
                }
            }
        }
    }

    // Closes the boundaries of each part, if it then encloses something.
    void close_holes() {
        const auto holes = find_holes();
        const std::size_t given = faces_.size();
        std::size_t closed = 0, edges = 0;
        float widest = 0;
        for (std::uint32_t i = 0; i < parts_.size(); ++i) {
            if (!parts_[i].has_holes()) continue;
            const std::size_t faces = faces_.size(), points = positions_.size();
            part whole = parts_[i];
            for (const std::vector<std::uint32_t>& hole : holes[i]) fill(hole, whole);
            const double area = whole.area - parts_[i].area, radius = std::sqrt(area / static_cast<double>(pi));
            if (std::fabs(whole.volume) <= min_thickness * radius * area) {
                for (auto slot = static_cast<std::uint32_t>(3 * faces); slot < 3 * faces_.size(); ++slot)
                    filled_.erase(half_edge{from(slot), to(slot), 0}.ends);
                faces_.resize(faces);
                positions_.resize(points);
                continue;
            }
            for (const std::vector<std::uint32_t>& hole : holes[i]) {
                aabb box;
                for (const std::uint32_t vertex : hole) box = merged(box, positions_[vertex]);
                ++closed;
                edges += hole.size();
                widest = max(widest, length(box.size()));
            }
        }
        if (closed == 0) return;
        note("Closed ", closed, "hole", "holes",
             " along " + counted(edges, "edge", "edges") + " with " + counted(faces_.size() - given, "face", "faces") +
                 "; the " + (closed == 1 ? "hole" : "largest") + " is " + number_text(1e3F * widest) + " mm wide.");
        // All faces are connected anew, as the given ones were, which stay as they are turned.
        edges_ = sorted_edges(faces_);
        connect();
        pair_crowded_edges();
        find_parts();
    }

    // The boundaries of each part as loops of vertices that pass none twice, against the sides of its faces.
    std::vector<std::vector<std::vector<std::uint32_t>>> find_holes() const {
        std::vector<std::vector<std::vector<std::uint32_t>>> holes(parts_.size());
        std::vector<std::uint8_t> is_done(twins_.size(), 0);
        std::vector<std::uint32_t> place(positions_.size(), none); // in the path
        std::vector<std::uint32_t> path;
        for (std::uint32_t begin = 0; begin < twins_.size(); ++begin) {
            const std::uint32_t own = part_of_[begin / 3];
            if (twins_[begin] != none || !parts_[own].has_holes()) continue;
            path.clear();
            for (std::uint32_t slot = begin; !is_done[slot];) {
                is_done[slot] = 1;
                place[from(slot)] = static_cast<std::uint32_t>(path.size());
                path.push_back(from(slot));
                if (const std::uint32_t met = place[to(slot)]; met != none) {
                    std::vector<std::uint32_t>& hole = holes[own].emplace_back();
                    for (; path.size() > met; path.pop_back()) {
                        hole.push_back(path.back());
                        place[path.back()] = none;
                    }
                    std::rotate(hole.begin(), hole.end() - 1, hole.end());
                }
                slot = next_side(slot);
                while (twins_[slot] != none) slot = next_side(twins_[slot]);
            }
        }
        return holes;
    }

    // Closes a hole by faces whose inner edges join vertices that have no edge yet.
    void fill(std::vector<std::uint32_t> loop, part& whole) {
        std::vector<dvec3> points;
        dvec3 centre{0, 0, 0};
        for (const std::uint32_t vertex : loop) {
            points.push_back(at(vertex));
            centre += points.back() / static_cast<double>(loop.size());
        }
        const auto is_free = [&](std::uint32_t i, std::uint32_t j) {
            const half_edge wanted{loop[i], loop[j], 0};
            const auto known = std::lower_bound(edges_.begin(), edges_.end(), wanted);
            return (known == edges_.end() || known->ends != wanted.ends) && !filled_.contains(wanted.ends);
        };
        const auto filling = loop_filler{points, is_free}.fill();
        if (filling.front()[2] == loop.size()) loop.push_back(add_vertex(vec3{centre}));
        for (const auto& [a, b, c] : filling) {
            for (const auto& [i, j] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}})
                filled_.insert(half_edge{loop[i], loop[j], 0}.ends);
            faces_.emplace_back(loop[a], loop[b], loop[c]);
            add_size(whole, faces_.back());
        }
    }

    // Orients closed parts outwards, and those inside of others, which are walls of cavities, inwards.
    void turn_outwards() {
        find_cavities();
        turn_faces([&](std::uint32_t face) {
            const part& own = part_at(face);
            return own.is_closed() && (own.volume < 0) != own.is_cavity;
        });
        std::vector<std::array<std::size_t, 2>> given(parts_.size(), {0, 0}); // faces that stayed, and that turned
        for (std::uint32_t face = 0; face < is_turned_.size(); ++face) ++given[part_of_[face]][is_turned_[face]];
        std::size_t faces = 0, bodies = 0, cavities = 0;
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            const auto [stayed, turned] = given[i];
            faces += std::min(stayed, turned);
            (parts_[i].is_cavity ? cavities : bodies) += turned > stayed ? 1 : 0;
        }
        note("Turned ", faces, "face", "faces", " that disagreed with the faces around.");
        note("Turned ", bodies, "part", "parts", " that faced inwards.");
        note("Turned ", cavities, "wall", "walls", " of a cavity inwards.");
    }

    // A closed part is a cavity if each of some points of it lies in an odd number of others: a line from there along x
    // crosses them an odd number of times.
    void find_cavities() {
        constexpr std::uint32_t points = 5; // of each part
        struct sample {
            std::int64_t row = 0; // along y
            sheared_ray line{};
            float z = 0;
            std::uint32_t part = 0;
            bool is_inside = false;
        };
        const mesh_view surface{positions_, faces_};
        aabb whole;
        for (const vec3& p : positions_) whole = merged(whole, p);
        const double height = static_cast<double>(max(whole.size().y, 1e-30F)) /
                              std::sqrt(static_cast<double>(std::max<std::size_t>(parts_.size(), 1)));
        const auto row_at = [&](float y) {
            return static_cast<std::int64_t>(std::floor((static_cast<double>(y) - whole.lower.y) / height));
        };
        std::vector<sample> samples;
        std::vector<std::uint32_t> seen(parts_.size(), 0);
        for (std::uint32_t face = 0; face < faces_.size(); ++face) {
            const std::uint32_t own = part_of_[face], step = std::max(1U, parts_[own].faces / points);
            if (!parts_[own].is_closed() || seen[own]++ % step != 0) continue;
            const triangle t = surface[face];
            const vec3 point = (t.a + t.b + t.c) / 3.0F;
            const sheared_ray line{ray{.origin = point, .direction = {1, 0, 0}}};
            samples.push_back({.row = row_at(point.y), .line = line, .z = point.z, .part = own});
            parts_[own].is_cavity = true;
        }
        const auto precedes = [](const sample& a, const sample& b) {
            return a.row != b.row ? a.row < b.row : a.z < b.z;
        };
        std::sort(samples.begin(), samples.end(), precedes);
        for (std::uint32_t face = 0; face < faces_.size(); ++face) {
            if (!part_at(face).is_closed()) continue;
            const triangle t = surface[face];
            const aabb box = bounds(t);
            for (std::int64_t row = row_at(box.lower.y); row <= row_at(box.upper.y); ++row) {
                const sample first{.row = row, .z = box.lower.z};
                auto one = std::lower_bound(samples.begin(), samples.end(), first, precedes);
                for (; one != samples.end() && one->row == row && one->z <= box.upper.z; ++one) {
                    const hit found = one->part != part_of_[face] ? intersect(one->line, t) : hit{};
                    one->is_inside = one->is_inside != (found && found.distance > 0);
                }
            }
        }
        for (const sample& one : samples) parts_[one.part].is_cavity = parts_[one.part].is_cavity && one.is_inside;
    }

    // Removes sheets that are small against the largest closed part, and says what is left as it was.
    void drop_sheets() {
        struct tally {
            std::size_t parts = 0, faces = 0;
        };
        tally loose, sheets, strips, crossed;
        double largest = 0;
        for (const part& own : parts_)
            if (own.is_closed()) largest = std::max(largest, own.area);
        for (part& own : parts_) {
            own.is_dropped = own.has_holes() && own.area < max_loose_area * largest;
            if (own.is_closed()) continue;
            tally& kind = own.is_one_sided ? strips : own.is_locked ? crossed : own.is_dropped ? loose : sheets;
            ++kind.parts;
            kind.faces += own.faces;
        }
        const auto with = [](const tally& all) { return " with " + counted(all.faces, "face", "faces"); };
        note("Removed ", loose.parts, "loose sheet", "loose sheets", with(loose) + ".");
        note("Left ", sheets.parts, "sheet", "sheets",
             with(sheets) + " open, which would enclose nothing: give it a thickness (`make_sheet`), or remove it.");
        note("Left ", strips.parts, "part", "parts",
             with(strips) + " as before: the surface has one side only, as that of a Moebius strip.");
        note("Left ", crossed.parts, "part", "parts",
             with(crossed) + " as before: faces are missing or too many at edges where more than two meet.");
    }

    // Gives each sheet of faces around a vertex a vertex of its own.
    void separate() {
        disjoint_sets corners{twins_.size()}; // by the side that begins at the corner
        const auto join_ends = [&](std::uint32_t a, std::uint32_t b) {
            const bool is_same_way = from(a) == from(b);
            corners.join(a, is_same_way ? b : next_side(b));
            corners.join(next_side(a), is_same_way ? next_side(b) : b);
        };
        for (std::uint32_t slot = 0; slot < twins_.size(); ++slot)
            if (slot < twins_[slot] && twins_[slot] < locked) join_ends(slot, twins_[slot]);
        for (const std::vector<std::uint32_t>& sides : crowded_)
            for (const std::uint32_t slot : sides)
                if (twins_[slot] == locked) join_ends(sides[0], slot);

        std::vector<std::uint32_t> sheets(positions_.size(), 0);   // around a vertex
        std::vector<std::uint32_t> vertex_of(twins_.size(), none); // of corners that stay
        for (std::uint32_t slot = 0; slot < twins_.size(); ++slot) {
            const std::uint32_t vertex = from(slot), first = corners.find(slot);
            if (part_at(slot / 3).is_dropped) continue;
            if (first < slot)
                vertex_of[slot] = vertex_of[first];
            else
                vertex_of[slot] = ++sheets[vertex] > 1 ? add_vertex(positions_[vertex]) : vertex;
        }

        std::vector<std::uint32_t> middle(twins_.size(), none); // of sides: edges between the same vertices are divided
        const auto first_middle = static_cast<std::uint32_t>(positions_.size());
        std::size_t along = 0;
        for (const std::vector<std::uint32_t>& sides : crowded_) {
            if (twins_[sides[0]] == locked) continue;
            const auto stay = std::count_if(sides.begin(), sides.end(),
                                            [&](std::uint32_t slot) { return !part_at(slot / 3).is_dropped; });
            along += stay > 2 ? 1 : 0;                         // sides of more than one surface
            sheets[from(sides[0])] = sheets[to(sides[0])] = 0; // they are told as an edge
            std::set<std::uint64_t> known;
            for (const std::uint32_t slot : sides) {
                const std::uint32_t a = vertex_of[slot], b = vertex_of[next_side(slot)];
                if (slot > twins_[slot] || a == none) continue;
                if (!known.insert(half_edge{a, b, 0}.ends).second)
                    middle[slot] = middle[twins_[slot]] = add_vertex(0.5F * (positions_[a] + positions_[b]));
            }
        }
        std::size_t apart = 0;
        for (const std::uint32_t count : sheets) apart += count > 1 ? 1 : 0;
        note("Separated surfaces that touched along ", along, "edge", "edges", ".");
        note("Separated surfaces that touched at ", apart, "vertex", "vertices", ".");

        std::vector<uvec3> faces;
        faces.reserve(faces_.size());
        std::vector<std::uint32_t> outline;
        for (std::uint32_t face = 0; face < faces_.size(); ++face) {
            if (part_at(face).is_dropped) continue;
            outline.clear();
            for (std::uint32_t slot = 3 * face; slot < 3 * face + 3; ++slot) {
                outline.push_back(vertex_of[slot]);
                if (middle[slot] != none) outline.push_back(middle[slot]);
            }
            const auto is_middle = [&](std::uint32_t vertex) { return vertex >= first_middle; };
            std::rotate(outline.begin(), std::find_if(outline.begin(), outline.end(), is_middle), outline.end());
            for (std::size_t i = 1; i + 1 < outline.size(); ++i) // from a middle, so that no triangle is flat
                faces.emplace_back(outline[0], outline[i], outline[i + 1]);
        }
        faces_ = std::move(faces);
    }

    void drop_unused_vertices() {
        std::vector<std::uint32_t> number(positions_.size(), none);
        for (const uvec3& f : faces_) number[f.x] = number[f.y] = number[f.z] = 0;
        std::uint32_t used = 0;
        for (std::uint32_t vertex = 0; vertex < number.size(); ++vertex) {
            if (number[vertex] == none) continue;
            positions_[used] = vec3{positions_[vertex]};
            number[vertex] = used++;
        }
        positions_.resize(used);
        for (uvec3& f : faces_) f = {number[f.x], number[f.y], number[f.z]};
    }

    std::vector<vec3> positions_;
    std::vector<uvec3> faces_;
    std::vector<std::string> notes_{};
    std::vector<half_edge> edges_{};                    // of the faces that were there, sorted
    std::set<std::uint64_t> filled_{};                  // edges of fillings
    std::vector<std::uint32_t> twins_{};                // the other side of the edge
    std::vector<std::vector<std::uint32_t>> crowded_{}; // the sides of each edge of three faces or more
    std::vector<std::uint8_t> is_turned_{};             // faces that were there
    std::vector<std::uint32_t> part_of_{};              // of a face
    std::vector<part> parts_{};
};

} // namespace detail

/// Mends a mesh so that it encloses a volume, as far as it is clear how, and says what it did.
///
/// Merges vertices at equal points, and those of open edges within a distance; removes faces without corners of their
/// own, copies of faces, and doubled walls between parts that touch; turns faces until neighbours agree and the body is
/// inside; closes holes by triangles between the vertices of their boundary, of the smallest area; and separates
/// surfaces that touch at an edge or vertex. An open sheet that would enclose nothing is left open, but removed where
/// it has less than 1 % of the area of a closed part. A surface of one side, and parts with edges of an odd number of
/// faces, are left as they are. `validate` tells what is left.
///
///     const repaired_mesh mended = repair(load_obj("heart.obj", {.unit = 1_mm}));
///     for (const std::string& note : mended.notes) std::puts(note.c_str());
///     if (!validate(mended.surface).closed()) ...
///
/// Cost: below a second for 400,000 faces.
/// @throws usage_error     for a distance out of range
/// @throws geometry_error  for a mesh without faces, a vertex that is not finite, or an index out of range
template <class Deferred = void>
repaired_mesh repair(const mesh_view& m, const repair_settings& settings = {}) {
    if (!(settings.weld_distance >= 0) || !(settings.weld_distance <= 0.01F))
        throw usage_error{"repair: `weld_distance` is ", settings.weld_distance,
                          " m; it must be from 0 to 0.01 m; write it as in 0.01_mm"};
    if (m.faces.empty())
        throw geometry_error{"repair: the mesh has no faces; check that the right file or object was read"};
    detail::check_faces(m, "repair: ");
    for (std::size_t i = 0; i < m.positions.size(); ++i)
        if (!is_finite(m.positions[i]))
            throw geometry_error{"repair: vertex ", i, " is not finite; check the computation or file it comes from"};
    return detail::mesh_repair{m, settings}.result();
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
