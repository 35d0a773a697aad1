#ifndef INSONIFY_GEOMETRY_REPAIR_HPP
#define INSONIFY_GEOMETRY_REPAIR_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/random.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/triangle.hpp>
#include <insonify/geometry/validate.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
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

/// "3 holes", "1 hole".
inline std::string counted(std::size_t count, const char* one, const char* many) {
    return std::to_string(count) + ' ' + (count == 1 ? one : many);
}

/// Triangulates closed loops of points in space.
class loop_filler {
  public:
    /// Three indices each into the loop; the index after its last point is that of its centre.
    using triangles = std::vector<std::array<std::uint32_t, 3>>;

    /// Of the smallest area; of a loop with more than 200 points first the shortest ears are cut off.
    /// @param loop     at least three points; the triangles have its orientation
    /// @param is_free  is_free(i, j): whether points may be joined by an edge
    /// Source: Barequet & Sharir 1995, "Filling gaps in the boundary of a polyhedron".
    template <class IsFree>
    static triangles fill(const std::vector<dvec3>& loop, const IsFree& is_free) {
        triangles found;
        std::vector<std::uint32_t> rest(loop.size());
        for (std::uint32_t i = 0; i < rest.size(); ++i) rest[i] = i;
        if (rest.size() > max_exact) cut_ears(loop, is_free, rest, found);
        if (rest.size() <= max_exact && fill_exactly(loop, is_free, rest, found)) return found;
        found.clear();
        const auto count = static_cast<std::uint32_t>(loop.size());
        for (std::uint32_t i = 0; i < count; ++i) found.push_back({i, (i + 1) % count, count});
        return found;
    }

  private:
    static constexpr std::size_t max_exact = 200; // points; the time grows with their third power
    static constexpr double compactness = 1e-4;   // among fillings of equal area those of short edges are chosen
    static constexpr double impossible = 1e300;   // area

    static double square(const dvec3& v) { return dot(v, v); }

    template <class IsFree>
    static bool fill_exactly(const std::vector<dvec3>& loop, const IsFree& is_free,
                             const std::vector<std::uint32_t>& rest, triangles& found) {
        const std::size_t count = rest.size();
        std::vector<double> least(count * count, 0.0); // cost of the polygon from i to j
        std::vector<std::uint32_t> apex(count * count, 0);
        const auto at = [&](std::size_t i) -> const dvec3& { return loop[rest[i]]; };
        for (std::size_t span = 2; span < count; ++span)
            for (std::size_t i = 0; i + span < count; ++i) {
                const std::size_t j = i + span;
                double best = impossible;
                if (span + 1 == count || is_free(rest[i], rest[j])) {
                    const double side = square(at(j) - at(i));
                    for (std::size_t k = i + 1; k < j; ++k) {
                        const dvec3 to_k = at(k) - at(i), to_j = at(j) - at(i);
                        const double own = std::sqrt(square(cross(to_k, to_j))) +
                                           compactness * (side + square(to_k) + square(to_j - to_k));
                        const double cost = least[i * count + k] + least[k * count + j] + own;
                        if (cost < best) {
                            best = cost;
                            apex[i * count + j] = static_cast<std::uint32_t>(k);
                        }
                    }
                }
                least[i * count + j] = best;
            }
        if (!(least[count - 1] < impossible)) return false;
        std::vector<std::pair<std::uint32_t, std::uint32_t>> open{{0, static_cast<std::uint32_t>(count - 1)}};
        while (!open.empty()) {
            const auto [i, j] = open.back();
            open.pop_back();
            if (j - i < 2) continue;
            const std::uint32_t k = apex[i * count + j];
            found.push_back({rest[i], rest[k], rest[j]});
            open.emplace_back(i, k);
            open.emplace_back(k, j);
        }
        return true;
    }

    // Cuts off triangles of two sides of the loop, those of the shortest third side first, until few points are left:
    // as long as there are any, convex ones that contain no other point, seen along the normal of the loop.
    template <class IsFree>
    static void cut_ears(const std::vector<dvec3>& loop, const IsFree& is_free, std::vector<std::uint32_t>& rest,
                         triangles& found) {
        const auto count = static_cast<std::uint32_t>(loop.size());
        dvec3 normal{0, 0, 0};
        for (std::uint32_t i = 0; i < count; ++i) normal += cross(loop[i] - loop[0], loop[(i + 1) % count] - loop[0]);
        std::vector<std::uint32_t> before(count), after(count);
        for (std::uint32_t i = 0; i < count; ++i) {
            before[i] = (i + count - 1) % count;
            after[i] = (i + 1) % count;
        }
        const auto side = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
            return dot(normal, cross(loop[b] - loop[a], loop[c] - loop[a]));
        };
        std::vector<std::uint32_t> reflex; // a convex corner stays one
        for (std::uint32_t i = 0; i < count; ++i)
            if (!(side(before[i], i, after[i]) > 0)) reflex.push_back(i);
        std::vector<std::uint8_t> is_cut(count, 0);
        const auto is_ear = [&](std::uint32_t i) {
            const std::uint32_t a = before[i], c = after[i];
            if (!(side(a, i, c) > 0) || !is_free(a, c)) return false;
            return std::none_of(reflex.begin(), reflex.end(), [&](std::uint32_t p) {
                return p != a && p != i && p != c && !is_cut[p] && side(a, i, p) >= 0 && side(i, c, p) >= 0 &&
                       side(c, a, p) >= 0;
            });
        };
        std::set<std::pair<double, std::uint32_t>> ears; // by length of the third side
        const auto ear_at = [&](std::uint32_t i) { return std::pair{square(loop[after[i]] - loop[before[i]]), i}; };
        std::size_t left = count;
        // An ear that was refused is tried again once others are gone; where no ear is one, any will do.
        for (bool is_strict = true, is_stuck = false; left > max_exact && !is_stuck;) {
            const std::size_t before_pass = left;
            for (std::uint32_t i = 0; i < count; ++i)
                if (!is_cut[i]) ears.insert(ear_at(i));
            while (left > max_exact && !ears.empty()) {
                const std::uint32_t i = ears.extract(ears.begin()).value().second, a = before[i], c = after[i];
                if (is_strict ? !is_ear(i) : !is_free(a, c)) continue;
                found.push_back({a, i, c});
                for (const std::uint32_t beside : {a, c}) ears.erase(ear_at(beside));
                is_cut[i] = 1;
                after[a] = c;
                before[c] = a;
                for (const std::uint32_t beside : {a, c}) ears.insert(ear_at(beside));
                --left;
            }
            is_stuck = !is_strict && left == before_pass;
            is_strict = is_strict && left < before_pass;
        }
        std::erase_if(rest, [&](std::uint32_t i) { return is_cut[i] != 0; });
    }
};

/// What `repair` does, step by step. Sides of faces are numbered as the slots of half edges.
class mesh_repair {
  public:
    mesh_repair(const mesh_view& given, const repair_settings& settings) {
        weld_equal(given);
        weld_open_edges(settings.weld_distance);
        drop_copies();
        connect();
        orient_patches();
        pair_crowded_edges();
        close_holes();
        turn_outwards();
        tell();
        separate();
    }

    repaired_mesh result() && { return {{std::move(positions_), std::move(faces_)}, std::move(notes_)}; }

  private:
    static constexpr std::uint32_t none = ~0U, locked = ~0U - 1; // no other side; more than two that do not match
    // A part is a sheet where its volume over the area of its holes, once closed, is less than this fraction of the
    // radius of that area: a disc with a bulge of 10 %, or a flat box without a lid.
    static constexpr double min_thickness = 0.05;
    static constexpr double max_loose_area = 0.01; // fraction of the largest closed part; smaller sheets are removed

    struct part { // faces connected by pairs of sides
        bool is_one_sided = false, is_locked = false, is_open = false, is_sheet = false, is_dropped = false;
        std::uint32_t faces = 0;
        double volume = 0, area = 0;
    };

    static std::uint32_t next_side(std::uint32_t slot) { return slot % 3 == 2 ? slot - 2 : slot + 1; }
    std::uint32_t from(std::uint32_t slot) const { return faces_[slot / 3][static_cast<int>(slot % 3)]; }
    std::uint32_t to(std::uint32_t slot) const { return from(next_side(slot)); }
    dvec3 at(std::uint32_t vertex) const { return dvec3{positions_[vertex]}; }
    void note(const std::string& sentence) { notes_.push_back(sentence); }

    // Merges vertices at equal points.
    void weld_equal(const mesh_view& given) {
        const std::vector<std::uint32_t> places = weld(given.positions);
        std::vector<std::uint8_t> is_used(given.positions.size(), 0);
        for (const uvec3& f : given.faces) is_used[f.x] = is_used[f.y] = is_used[f.z] = 1;
        std::vector<std::uint32_t> kept_as(given.positions.size(), none), number(given.positions.size(), none);
        std::size_t merged = 0, unused = 0;
        for (std::uint32_t vertex = 0; vertex < number.size(); ++vertex) {
            std::uint32_t& known = kept_as[places[vertex]];
            if (!is_used[vertex]) {
                ++unused;
                continue;
            }
            if (known == none) {
                known = static_cast<std::uint32_t>(positions_.size());
                positions_.push_back(given.positions[vertex]);
            } else {
                ++merged;
            }
            number[vertex] = known;
        }
        if (unused > 0) note("Removed " + counted(unused, "vertex", "vertices") + " without faces.");
        if (merged > 0)
            note("Merged " + counted(merged, "vertex", "vertices") + " with another one at the same point.");
        faces_.assign(given.faces.begin(), given.faces.end());
        renumber(number);
    }

    // Gives faces other vertices, and removes those that lose a corner.
    void renumber(const std::vector<std::uint32_t>& number) {
        const std::size_t before = faces_.size();
        for (uvec3& f : faces_) f = {number[f.x], number[f.y], number[f.z]};
        std::erase_if(faces_, [](const uvec3& f) { return f.x == f.y || f.y == f.z || f.z == f.x; });
        if (faces_.size() < before)
            note("Removed " + counted(before - faces_.size(), "face", "faces") +
                 " with two corners at the same point.");
    }

    // Merges each vertex of an open edge with the nearest of those before it that were kept. Others stay: a closed
    // surface may be finer than the distance.
    void weld_open_edges(float distance) {
        std::vector<std::uint8_t> is_open(positions_.size(), 0);
        const std::vector<half_edge> edges = sorted_edges(faces_);
        for (std::size_t i = 0; i < edges.size(); ++i) {
            const bool is_single = (i == 0 || edges[i - 1].ends != edges[i].ends) &&
                                   (i + 1 == edges.size() || edges[i + 1].ends != edges[i].ends);
            if (is_single) is_open[edges[i].lower()] = is_open[edges[i].upper()] = 1;
        }
        std::size_t size = 1;
        while (size < 2 * static_cast<std::size_t>(std::count(is_open.begin(), is_open.end(), 1))) size *= 2;
        if (size == 1 || !(distance > 0)) return;

        // Vertices that were kept, by the cells of a grid: lists in a hash table.
        const double within = static_cast<double>(distance), cell = 8 * within;
        std::vector<std::uint32_t> first(size, none), following(positions_.size(), none), number(positions_.size());
        const auto bucket = [&](const dvec3& point) {
            std::uint64_t hash = 0;
            for (int i = 0; i < 3; ++i)
                hash = hash_bits(hash, __builtin_bit_cast(std::uint64_t, std::floor(point[i] / cell) + 0.0));
            return static_cast<std::size_t>(hash & (size - 1));
        };
        std::size_t merged = 0;
        for (std::uint32_t vertex = 0; vertex < number.size(); ++vertex) {
            number[vertex] = vertex;
            if (!is_open[vertex]) continue;
            const dvec3 here = at(vertex);
            double nearest = within * within;
            for (int corner = 0; corner < 8; ++corner) { // of the box around it that lies in one to eight cells
                dvec3 point = here;
                bool is_other_cell = true;
                for (int i = 0; i < 3; ++i) {
                    const double low = here[i] - within, high = here[i] + within;
                    const bool is_upper = (corner >> i & 1) != 0;
                    is_other_cell = is_other_cell && !(is_upper && std::floor(low / cell) == std::floor(high / cell));
                    point[i] = is_upper ? high : low;
                }
                if (!is_other_cell) continue;
                for (std::uint32_t other = first[bucket(point)]; other != none; other = following[other])
                    if (const dvec3 apart = at(other) - here; dot(apart, apart) <= nearest) {
                        nearest = dot(apart, apart);
                        number[vertex] = other;
                    }
            }
            if (number[vertex] == vertex)
                following[vertex] = std::exchange(first[bucket(here)], vertex);
            else
                ++merged;
        }
        if (merged == 0) return;
        note("Merged " + counted(merged, "vertex", "vertices") + " of open edges with another one within " +
             number_text(1e3F * distance) + " mm.");
        renumber(number);
    }

    // Keeps one of the faces with the same corners, and none of those that are a wall inside a body.
    void drop_copies() {
        std::vector<std::pair<std::array<std::uint32_t, 3>, std::uint32_t>> all; // corners and number of each face
        all.reserve(faces_.size());
        for (std::uint32_t i = 0; i < faces_.size(); ++i) {
            all.push_back({{faces_[i].x, faces_[i].y, faces_[i].z}, i});
            std::sort(all.back().first.begin(), all.back().first.end());
        }
        std::sort(all.begin(), all.end());
        std::vector<std::uint32_t> copies(faces_.size(), 0); // of a face that is kept; none: of one that is not
        std::size_t removed = 0;
        for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
            for (end = begin + 1; end < all.size() && all[end].first == all[begin].first; ++end, ++removed)
                copies[all[end].second] = none;
            copies[all[begin].second] = static_cast<std::uint32_t>(end - begin - 1);
        }
        if (removed == 0) return;
        // A patch of doubled faces is a wall where its borders have two other faces each, or four.
        disjoint_sets patches{faces_.size()};
        const std::vector<half_edge> edges = sorted_edges(faces_);
        std::vector<std::uint8_t> has_border(faces_.size(), 0), is_surface(faces_.size(), 0);
        const auto for_each_edge = [&](const auto& visit) { // visit(doubled faces, number of others)
            std::vector<std::uint32_t> doubled;
            for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
                std::size_t others = 0;
                doubled.clear();
                for (; end < edges.size() && edges[end].ends == edges[begin].ends; ++end) {
                    const std::uint32_t face = edges[end].slot / 3;
                    others += copies[face] == 0 ? 1 : 0;
                    if (copies[face] != 0 && copies[face] != none) doubled.push_back(face);
                }
                visit(doubled, others);
            }
        };
        for_each_edge([&](const std::vector<std::uint32_t>& doubled, std::size_t others) {
            for (const std::uint32_t face : doubled)
                if (others == 0) patches.join(doubled[0], face);
        });
        for_each_edge([&](const std::vector<std::uint32_t>& doubled, std::size_t others) {
            for (const std::uint32_t face : doubled)
                if (others > 0) (others % 2 == 0 ? has_border : is_surface)[patches.find(face)] = 1;
        });
        std::size_t walls = 0, kept = 0;
        for (std::uint32_t i = 0; i < faces_.size(); ++i) {
            if (copies[i] == none) continue;
            const std::uint32_t patch = patches.find(i);
            if (copies[i] > 0 && has_border[patch] && !is_surface[patch]) {
                walls += 1 + copies[i];
                removed -= copies[i];
            } else {
                faces_[kept++] = faces_[i];
            }
        }
        faces_.resize(kept);
        if (removed > 0) note("Removed " + counted(removed, "copy", "copies") + " of faces.");
        if (walls > 0) note("Removed " + counted(walls, "face", "faces") + " of walls between parts that touch.");
    }

    // Pairs the two sides of each edge of two faces.
    void connect() {
        edges_ = sorted_edges(faces_);
        twins_.assign(3 * faces_.size(), none);
        for (std::size_t begin = 0, end = 0; begin < edges_.size(); begin = end) {
            while (end < edges_.size() && edges_[end].ends == edges_[begin].ends) ++end;
            if (end - begin == 2) {
                join(edges_[begin].slot, edges_[begin + 1].slot);
            } else if (end - begin > 2) {
                crowded_.emplace_back();
                for (std::size_t i = begin; i < end; ++i) {
                    crowded_.back().push_back(edges_[i].slot);
                    twins_[edges_[i].slot] = locked;
                }
            }
        }
    }
    void join(std::uint32_t a, std::uint32_t b) {
        twins_[a] = b;
        twins_[b] = a;
    }

    // Turns the faces that differ from most of their patch: of faces that pairs connect.
    void orient_patches() {
        is_turned_.assign(faces_.size(), 0);
        patch_of_.assign(faces_.size(), none);
        std::vector<std::uint32_t> members;
        for (std::uint32_t seed = 0; seed < faces_.size(); ++seed) {
            if (patch_of_[seed] != none) continue;
            const auto patch = static_cast<std::uint32_t>(one_sided_.size());
            bool is_one_sided = false;
            std::size_t turned = 0;
            members.assign(1, seed);
            patch_of_[seed] = patch;
            for (std::size_t i = 0; i < members.size(); ++i)
                for (std::uint32_t slot = 3 * members[i]; slot < 3 * members[i] + 3; ++slot) {
                    const std::uint32_t twin = twins_[slot];
                    if (twin >= locked) continue;
                    const std::uint32_t other = twin / 3;
                    const bool differ = from(slot) == from(twin);
                    const auto wanted =
                        static_cast<std::uint8_t>(differ ? 1 - is_turned_[members[i]] : is_turned_[members[i]]);
                    if (patch_of_[other] == none) {
                        patch_of_[other] = patch;
                        is_turned_[other] = wanted;
                        turned += wanted;
                        members.push_back(other);
                    } else {
                        is_one_sided = is_one_sided || is_turned_[other] != wanted;
                    }
                }
            one_sided_.push_back(is_one_sided);
            const bool turn_others = 2 * turned > members.size();
            for (const std::uint32_t face : members)
                is_turned_[face] = static_cast<std::uint8_t>(!is_one_sided && (is_turned_[face] != 0) != turn_others);
        }
    }
    // Whether a side leads from the vertex of the lower index to that of the higher one, as turned.
    bool is_upwards(std::uint32_t slot) const { return (from(slot) < to(slot)) != (is_turned_[slot / 3] != 0); }

    // Pairs the sides of edges of four faces and more, around each wedge of the body.
    void pair_crowded_edges() {
        if (!crowded_.empty()) turn_closed_patches();
        for (const std::vector<std::uint32_t>& sides : crowded_) {
            bool has_one_sided = false;
            for (const std::uint32_t slot : sides) has_one_sided = has_one_sided || one_sided_[patch_of_[slot / 3]];
            if (sides.size() % 2 != 0 || has_one_sided) continue;
            const std::uint32_t low = std::min(from(sides[0]), to(sides[0])),
                                high = std::max(from(sides[0]), to(sides[0]));
            const dvec3 along = at(high) - at(low);
            struct spoke {
                double angle;
                std::uint32_t slot;
                bool opens; // the body begins here, in the sense of rising angles
            };
            std::vector<spoke> spokes;
            dvec3 zero{0, 0, 0};
            for (const std::uint32_t slot : sides) {
                const dvec3 corner = at(to(next_side(slot))) - at(low);
                const dvec3 across = corner - (dot(corner, along) / dot(along, along)) * along;
                if (spokes.empty()) zero = across;
                const double angle =
                    std::atan2(dot(cross(zero, across), along) / std::sqrt(dot(along, along)), dot(zero, across));
                spokes.push_back({spokes.empty() ? 0 : angle, slot, !is_upwards(slot)});
            }
            std::sort(spokes.begin(), spokes.end(), [](const spoke& a, const spoke& b) {
                return a.angle != b.angle ? a.angle < b.angle : a.slot < b.slot;
            });
            const auto opening = std::count_if(spokes.begin(), spokes.end(), [](const spoke& s) { return s.opens; });
            if (2 * static_cast<std::size_t>(opening) != spokes.size()) continue;
            std::vector<std::uint32_t> open; // as brackets
            for (std::size_t turn = 0; turn < 2 * spokes.size(); ++turn) {
                const spoke& next = spokes[turn % spokes.size()];
                if (twins_[next.slot] != locked) continue;
                if (next.opens && turn < spokes.size()) {
                    open.push_back(next.slot);
                } else if (!next.opens && !open.empty()) {
                    join(open.back(), next.slot);
                    open.pop_back();
                }
            }
        }
    }
    // Patches that are closed by themselves are oriented outwards: pairing needs to know where the body is.
    void turn_closed_patches() {
        std::vector<double> volume(one_sided_.size(), 0.0);
        std::vector<std::uint8_t> is_closed(one_sided_.size(), 1);
        for (std::uint32_t face = 0; face < faces_.size(); ++face) {
            const dvec3 a = at(faces_[face].x), b = at(faces_[face].y), c = at(faces_[face].z);
            const double own = dot(a - at(0), cross(b - a, c - a));
            volume[patch_of_[face]] += is_turned_[face] != 0 ? -own : own;
        }
        for (const std::vector<std::uint32_t>& sides : crowded_)
            for (const std::uint32_t slot : sides) {
                int balance = 0;
                for (const std::uint32_t other : sides)
                    if (patch_of_[other / 3] == patch_of_[slot / 3]) balance += is_upwards(other) ? 1 : -1;
                if (balance != 0) is_closed[patch_of_[slot / 3]] = 0;
            }
        for (std::uint32_t slot = 0; slot < twins_.size(); ++slot)
            if (twins_[slot] == none) is_closed[patch_of_[slot / 3]] = 0;
        for (std::uint32_t face = 0; face < faces_.size(); ++face) {
            const std::uint32_t patch = patch_of_[face];
            if (is_closed[patch] && !one_sided_[patch] && volume[patch] < 0)
                is_turned_[face] = static_cast<std::uint8_t>(1 - is_turned_[face]);
        }
    }

    // Swaps corners and sides of turned faces.
    void turn_faces(const std::vector<std::uint8_t>& turned) {
        const auto moved = [&](std::uint32_t slot) {
            return slot < locked && turned[slot / 3] != 0 ? slot + 2 - 2 * (slot % 3) : slot;
        };
        for (std::uint32_t face = 0; face < faces_.size(); ++face) {
            if (turned[face] == 0) continue;
            std::swap(faces_[face].y, faces_[face].z);
            std::swap(twins_[std::size_t{3} * face], twins_[std::size_t{3} * face + 2]);
        }
        for (std::uint32_t& twin : twins_) twin = moved(twin);
        for (std::vector<std::uint32_t>& sides : crowded_)
            for (std::uint32_t& slot : sides) slot = moved(slot);
    }

    // Numbers the parts and adds up what is known of them.
    void find_parts() {
        disjoint_sets joined{faces_.size()};
        for (std::uint32_t slot = 0; slot < twins_.size(); ++slot)
            if (twins_[slot] < locked) joined.join(slot / 3, twins_[slot] / 3);
        for (std::uint32_t face = 0; face < faces_.size(); ++face) {
            const std::uint32_t first = joined.find(face);
            part_of_.push_back(first < face ? part_of_[first] : static_cast<std::uint32_t>(parts_.size()));
            if (first == face) parts_.emplace_back();
            part& own = parts_[part_of_[face]];
            own.is_one_sided = own.is_one_sided || one_sided_[patch_of_[face]];
            for (std::uint32_t slot = 3 * face; slot < 3 * face + 3; ++slot) {
                own.is_locked = own.is_locked || twins_[slot] == locked;
                own.is_open = own.is_open || twins_[slot] == none;
            }
            add(own, at(faces_[face].x), at(faces_[face].y), at(faces_[face].z));
        }
    }
    void add(part& own, const dvec3& a, const dvec3& b, const dvec3& c) const {
        const dvec3 area = cross(b - a, c - a);
        ++own.faces;
        own.volume += dot(a - at(0), area) / 6;
        own.area += length(area) / 2;
    }

    struct hole {
        std::vector<std::uint32_t> sides{}; // of faces around it
        std::vector<std::uint32_t> loop{};  // vertices, against these sides
        dvec3 centre{0, 0, 0};
        loop_filler::triangles filling{}; // of indices into the loop
    };

    // Closes the boundaries of each part, if it then encloses something.
    void close_holes() {
        turn_faces(is_turned_);
        find_parts();
        std::vector<std::vector<hole>> holes(parts_.size());
        find_holes(holes);
        std::size_t closed = 0, edges = 0, added = 0;
        double widest = 0;
        for (std::uint32_t i = 0; i < parts_.size(); ++i) {
            part& own = parts_[i];
            if (!own.is_open || own.is_one_sided || own.is_locked) continue;
            part whole = own;
            for (hole& one : holes[i]) fill(one, whole);
            const double area = whole.area - own.area, radius = std::sqrt(area / static_cast<double>(pi));
            own.is_sheet = std::fabs(whole.volume) <= min_thickness * radius * area;
            if (own.is_sheet) continue;
            own = whole;
            own.is_open = false;
            for (const hole& one : holes[i]) {
                ++closed;
                edges += one.sides.size();
                added += one.filling.size();
                widest = std::max(widest, width_of(one));
                add_filling(one, i);
            }
        }
        if (closed > 0)
            note("Closed " + counted(closed, "hole", "holes") + " along " + counted(edges, "edge", "edges") + " with " +
                 counted(added, "face", "faces") + "; the " + (closed == 1 ? "hole" : "largest") + " is " +
                 number_text(static_cast<float>(1e3 * widest)) + " mm wide.");
    }

    double width_of(const hole& one) const {
        aabb box;
        for (const std::uint32_t slot : one.sides) box = merged(box, positions_[from(slot)]);
        return static_cast<double>(length(box.size()));
    }

    // The boundaries of each part as loops that pass no vertex twice.
    void find_holes(std::vector<std::vector<hole>>& holes) const {
        std::vector<std::uint8_t> is_done(twins_.size(), 0);
        std::vector<std::uint32_t> place(positions_.size(), none); // in the path
        std::vector<std::uint32_t> path;
        for (std::uint32_t begin = 0; begin < twins_.size(); ++begin) {
            const part& own = parts_[part_of_[begin / 3]];
            if (twins_[begin] != none || is_done[begin] || own.is_one_sided || own.is_locked) continue;
            path.clear();
            for (std::uint32_t slot = begin; !is_done[slot];) {
                is_done[slot] = 1;
                place[from(slot)] = static_cast<std::uint32_t>(path.size());
                path.push_back(slot);
                if (const std::uint32_t met = place[to(slot)]; met != none) {
                    holes[part_of_[begin / 3]].push_back(
                        {{path.begin() + static_cast<std::ptrdiff_t>(met), path.end()}});
                    for (std::size_t i = met; i < path.size(); ++i) place[from(path[i])] = none;
                    path.resize(met);
                }
                std::uint32_t following = next_side(slot);
                while (twins_[following] != none) following = next_side(twins_[following]);
                slot = following;
            }
        }
    }

    // The filling must not join vertices that have an edge already.
    void fill(hole& one, part& whole) {
        if (one.sides.size() == 2) return; // they are joined
        std::vector<dvec3> points;
        for (std::size_t i = one.sides.size(); i-- > 0;) {
            one.loop.push_back(to(one.sides[i]));
            points.push_back(at(one.loop.back()));
        }
        const auto edge = [&](std::uint32_t i, std::uint32_t j) { return half_edge{one.loop[i], one.loop[j], 0}.ends; };
        one.filling = loop_filler::fill(points, [&](std::uint32_t i, std::uint32_t j) {
            const std::uint64_t wanted = edge(i, j);
            const auto known = std::lower_bound(edges_.begin(), edges_.end(), wanted,
                                                [](const half_edge& e, std::uint64_t ends) { return e.ends < ends; });
            return (known == edges_.end() || known->ends != wanted) && !joined_.contains(wanted);
        });
        const auto count = static_cast<std::uint32_t>(points.size());
        for (const dvec3& point : points) one.centre += point / static_cast<double>(count);
        points.push_back(one.centre);
        for (const auto& [a, b, c] : one.filling) {
            for (const auto& [i, j] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}})
                if (i < j && j < count && j - i > 1 && j - i + 1 < count) joined_.insert(edge(i, j));
            add(whole, points[a], points[b], points[c]);
        }
    }

    void add_filling(const hole& one, std::uint32_t own) {
        if (one.sides.size() == 2) {
            join(one.sides[0], one.sides[1]);
            return;
        }
        std::vector<half_edge> edges;
        for (const std::uint32_t slot : one.sides) edges.emplace_back(from(slot), to(slot), slot);
        std::vector<std::uint32_t> vertices = one.loop;
        if (one.filling.front()[2] == vertices.size()) {
            vertices.push_back(static_cast<std::uint32_t>(positions_.size()));
            positions_.emplace_back(one.centre);
        }
        for (const auto& [a, b, c] : one.filling) {
            const auto face = static_cast<std::uint32_t>(faces_.size());
            faces_.emplace_back(vertices[a], vertices[b], vertices[c]);
            part_of_.push_back(own);
            twins_.insert(twins_.end(), 3, none);
            for (std::uint32_t slot = 3 * face; slot < 3 * face + 3; ++slot)
                edges.emplace_back(from(slot), to(slot), slot);
        }
        sort_by_ends(edges);
        for (std::size_t i = 0; i + 1 < edges.size(); i += 2) join(edges[i].slot, edges[i + 1].slot);
    }

    // Orients closed parts outwards, and those inside of others, which are walls of cavities, inwards.
    void turn_outwards() {
        const std::vector<std::uint8_t> is_cavity = find_cavities();
        const std::size_t given = is_turned_.size();
        std::vector<std::uint8_t> is_inverted(faces_.size(), 0);
        std::vector<std::size_t> turned(parts_.size(), 0), all(parts_.size(), 0);
        for (std::uint32_t face = 0; face < faces_.size(); ++face) {
            const std::uint32_t i = part_of_[face];
            is_inverted[face] = is_closed(parts_[i]) && (parts_[i].volume < 0) != (is_cavity[i] != 0);
            if (face >= given) continue;
            turned[i] += is_inverted[face] != is_turned_[face] ? 1 : 0;
            ++all[i];
        }
        turn_faces(is_inverted);
        std::size_t faces = 0, bodies = 0, cavities = 0;
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            const bool whole = 2 * turned[i] > all[i];
            faces += whole ? all[i] - turned[i] : turned[i];
            (is_cavity[i] != 0 ? cavities : bodies) += whole ? 1 : 0;
        }
        if (faces > 0) note("Turned " + counted(faces, "face", "faces") + " that disagreed with the faces around.");
        if (bodies > 0) note("Turned " + counted(bodies, "part", "parts") + " that faced inwards.");
        if (cavities > 0) note("Turned " + counted(cavities, "wall", "walls") + " of a cavity inwards.");
    }
    static bool is_closed(const part& own) { return !own.is_open && !own.is_locked && !own.is_one_sided; }

    // The closed parts of which some points lie in an odd number of others. Their faces are found in columns along x.
    std::vector<std::uint8_t> find_cavities() const {
        constexpr std::size_t points = 5; // of each part
        std::vector<std::uint8_t> is_cavity(parts_.size(), 0);
        if (std::count_if(parts_.begin(), parts_.end(), is_closed) < 2) return is_cavity;
        aabb whole;
        for (const vec3& p : positions_) whole = merged(whole, p);
        const auto side = static_cast<std::uint32_t>(clamp(std::sqrt(static_cast<float>(faces_.size())), 1, 512));
        const auto column = [&](float value, int axis) {
            const float place = (value - whole.lower[axis]) / max(whole.size()[axis], 1e-30F);
            return std::min(static_cast<std::uint32_t>(place * static_cast<float>(side)), side - 1);
        };
        const auto for_each_column = [&](std::uint32_t face, const auto& visit) {
            const aabb box = bounds(mesh_view{positions_, faces_}[face]);
            for (std::uint32_t y = column(box.lower.y, 1); y <= column(box.upper.y, 1); ++y)
                for (std::uint32_t z = column(box.lower.z, 2); z <= column(box.upper.z, 2); ++z)
                    visit(y * std::size_t{side} + z);
        };
        std::vector<std::size_t> ends(std::size_t{side} * side + 1, 0);
        for (std::uint32_t face = 0; face < faces_.size(); ++face)
            if (is_closed(parts_[part_of_[face]])) for_each_column(face, [&](std::size_t i) { ++ends[i + 1]; });
        for (std::size_t i = 1; i < ends.size(); ++i) ends[i] += ends[i - 1];
        std::vector<std::uint32_t> members(ends.back());
        std::vector<std::size_t> next = ends;
        for (std::uint32_t face = 0; face < faces_.size(); ++face)
            if (is_closed(parts_[part_of_[face]]))
                for_each_column(face, [&](std::size_t i) { members[next[i]++] = face; });

        const auto is_inside = [&](vec3 point, std::uint32_t own) {
            const sheared_ray line{ray{.origin = point, .direction = {1, 0, 0}}};
            std::vector<std::uint32_t> crossed;
            const std::size_t i = column(point.y, 1) * std::size_t{side} + column(point.z, 2);
            for (std::size_t k = ends[i]; k < ends[i + 1]; ++k) {
                const std::uint32_t other = part_of_[members[k]];
                if (other == own) continue;
                const hit found = intersect(line, mesh_view{positions_, faces_}[members[k]]);
                if (found && found.distance > 0) crossed.push_back(other);
            }
            std::sort(crossed.begin(), crossed.end());
            std::size_t around = 0; // parts that are crossed an odd number of times
            for (std::size_t begin = 0, end = 0; begin < crossed.size(); begin = end) {
                while (end < crossed.size() && crossed[end] == crossed[begin]) ++end;
                around += (end - begin) % 2;
            }
            return around % 2 != 0;
        };
        std::vector<std::uint32_t> seen(parts_.size(), 0);
        for (std::uint32_t i = 0; i < parts_.size(); ++i) is_cavity[i] = is_closed(parts_[i]);
        for (std::uint32_t face = 0; face < faces_.size(); ++face) {
            const std::uint32_t own = part_of_[face];
            const std::uint32_t step = std::max<std::uint32_t>(1, parts_[own].faces / points);
            if (seen[own]++ % step != 0 || !is_cavity[own]) continue;
            const triangle t = mesh_view{positions_, faces_}[face];
            is_cavity[own] = is_inside((t.a + t.b + t.c) / 3.0F, own);
        }
        return is_cavity;
    }

    // Removes sheets that are small against the largest closed part, and says what is left as it was.
    void tell() {
        double largest = 0;
        std::size_t sheets = 0, sheet_faces = 0, loose = 0, loose_faces = 0, strips = 0, strip_faces = 0;
        for (const part& own : parts_)
            if (is_closed(own)) largest = std::max(largest, own.area);
        for (part& own : parts_) {
            own.is_dropped = own.is_sheet && own.area < max_loose_area * largest;
            (own.is_dropped ? loose : sheets) += own.is_sheet ? 1 : 0;
            (own.is_dropped ? loose_faces : sheet_faces) += own.is_sheet ? own.faces : 0;
            strips += own.is_one_sided ? 1 : 0;
            strip_faces += own.is_one_sided ? own.faces : 0;
        }
        if (loose > 0)
            note("Removed " + counted(loose, "loose sheet", "loose sheets") + " with " +
                 counted(loose_faces, "face", "faces") + ".");
        if (sheets > 0)
            note("Left " + counted(sheets, "sheet", "sheets") + " with " + counted(sheet_faces, "face", "faces") +
                 " open, which would enclose nothing: give it a thickness (`make_sheet`), or remove it.");
        if (strips > 0)
            note("Left " + counted(strips, "part", "parts") + " with " + counted(strip_faces, "face", "faces") +
                 " as before: the surface has one side only, as that of a Moebius strip.");
    }

    // Gives each sheet of faces around a vertex a vertex of its own, and removes what no face uses.
    void separate() {
        disjoint_sets corners{twins_.size()}; // by the side that begins at the corner
        const auto corner = [&](std::uint32_t slot, std::uint32_t vertex) {
            return from(slot) == vertex ? slot : next_side(slot);
        };
        const auto join_ends = [&](std::uint32_t a, std::uint32_t b) {
            for (const std::uint32_t vertex : {from(a), to(a)}) corners.join(corner(a, vertex), corner(b, vertex));
        };
        for (std::uint32_t slot = 0; slot < twins_.size(); ++slot)
            if (slot < twins_[slot] && twins_[slot] < locked) join_ends(slot, twins_[slot]);
        for (const std::vector<std::uint32_t>& sides : crowded_)
            for (const std::uint32_t slot : sides)
                if (twins_[slot] == locked) join_ends(sides[0], slot);

        std::vector<std::uint32_t> first(positions_.size(), none), vertex_of(twins_.size(), none);
        std::vector<std::uint8_t> is_split(positions_.size(), 0);
        for (std::uint32_t slot = 0; slot < twins_.size(); ++slot) {
            if (parts_[part_of_[slot / 3]].is_dropped) continue;
            std::uint32_t& own = vertex_of[corners.find(slot)];
            if (own == none) {
                const std::uint32_t vertex = from(slot);
                own = first[vertex] == none ? vertex : static_cast<std::uint32_t>(positions_.size());
                if (first[vertex] != none) {
                    is_split[vertex] = 1;
                    positions_.push_back(vec3{positions_[vertex]});
                }
                first[vertex] = own;
            }
        }
        std::vector<std::uint32_t> middle(twins_.size(), none);
        const auto first_middle = static_cast<std::uint32_t>(positions_.size());
        const auto end = [&](std::uint32_t slot) { return vertex_of[corners.find(slot)]; };
        std::size_t along = 0;
        for (const std::vector<std::uint32_t>& sides : crowded_) {
            if (twins_[sides[0]] >= locked) continue;
            along += 1;
            is_split[from(sides[0])] = is_split[to(sides[0])] = 0;
            std::vector<std::uint64_t> known;
            for (const std::uint32_t slot : sides) {
                const std::uint32_t a = end(slot), b = end(next_side(slot));
                const std::uint64_t ends = half_edge{a, b, 0}.ends;
                if (slot > twins_[slot]) continue;
                if (std::find(known.begin(), known.end(), ends) == known.end()) {
                    known.push_back(ends);
                    continue;
                }
                middle[slot] = middle[twins_[slot]] = static_cast<std::uint32_t>(positions_.size());
                positions_.push_back(0.5F * (positions_[a] + positions_[b]));
            }
        }
        const auto apart = static_cast<std::size_t>(std::count(is_split.begin(), is_split.end(), 1));
        if (along > 0) note("Separated surfaces that touched along " + counted(along, "edge", "edges") + ".");
        if (apart > 0) note("Separated surfaces that touched at " + counted(apart, "vertex", "vertices") + ".");

        std::vector<uvec3> faces;
        faces.reserve(faces_.size());
        for (std::uint32_t face = 0; face < faces_.size(); ++face) {
            if (parts_[part_of_[face]].is_dropped) continue;
            std::vector<std::uint32_t> outline;
            for (std::uint32_t slot = 3 * face; slot < 3 * face + 3; ++slot) {
                outline.push_back(end(slot));
                if (middle[slot] != none) outline.push_back(middle[slot]);
            }
            // Begin at a middle, so that no triangle is flat.
            std::rotate(
                outline.begin(),
                std::find_if(outline.begin(), outline.end(), [&](std::uint32_t v) { return v >= first_middle; }),
                outline.end());
            for (std::size_t i = 1; i + 1 < outline.size(); ++i)
                faces.emplace_back(outline[0], outline[i], outline[i + 1]);
        }
        std::vector<std::uint32_t> number(positions_.size(), none);
        for (const uvec3& f : faces) number[f.x] = number[f.y] = number[f.z] = 0;
        std::uint32_t used = 0;
        for (std::size_t i = 0; i < number.size(); ++i)
            if (number[i] != none) {
                positions_[used] = vec3{positions_[i]};
                number[i] = used++;
            }
        positions_.resize(used);
        for (uvec3& f : faces) f = {number[f.x], number[f.y], number[f.z]};
        faces_ = std::move(faces);
    }

    std::vector<vec3> positions_{};
    std::vector<uvec3> faces_{};
    std::vector<std::string> notes_{};
    std::vector<half_edge> edges_{};                    // of the faces that were there, sorted
    std::set<std::uint64_t> joined_{};                  // edges across fillings
    std::vector<std::uint32_t> twins_{};                // the other side of the edge
    std::vector<std::vector<std::uint32_t>> crowded_{}; // the sides of each edge of three faces or more
    std::vector<std::uint8_t> is_turned_{};             // faces that were there
    std::vector<std::uint32_t> patch_of_{};             // of these: connected by edges of two faces
    std::vector<bool> one_sided_{};                     // patches
    std::vector<std::uint32_t> part_of_{};              // of a face
    std::vector<part> parts_{};
};

} // namespace detail

/// Mends a mesh so that it encloses a volume, as far as it is clear how, and says what it did.
///
/// Merges vertices at equal points, and those of open edges within a distance; removes faces without corners of their
/// own, copies of faces, and doubled walls between parts that touch; turns faces until neighbours agree and the body is
/// inside; closes holes by triangles between the vertices of their boundary, of the smallest area; and separates
/// surfaces that touch at an edge or vertex. An open sheet that would enclose nothing is left open, but removed where it
/// has less than 1 % of the area of a closed part. A surface of one side, and parts with edges of an odd number of
/// faces, are left as they are. `validate` tells what is left.
///
///     const repaired_mesh mended = repair(load_obj("heart.obj", {.unit = 1_mm}));
///     for (const std::string& note : mended.notes) std::puts(note.c_str());
///     if (!validate(mended.surface).closed()) ...
///
/// Cost: below a second for 400,000 faces.
/// @throws usage_error     for a distance out of range
/// @throws geometry_error  for a mesh without faces, a vertex that is not finite, or an index out of range
inline repaired_mesh repair(const mesh_view& m, const repair_settings& settings = {}) {
    if (!(settings.weld_distance >= 0) || !(settings.weld_distance <= 0.01F))
        throw usage_error{"repair: `weld_distance` is " + detail::number_text(settings.weld_distance) +
                          " m; it must be from 0 to 0.01 m; write it as in 0.01_mm"};
    if (m.faces.empty())
        throw geometry_error{"repair: the mesh has no faces; check that the right file or object was read"};
    detail::check_faces(m, "repair: ");
    for (std::size_t i = 0; i < m.positions.size(); ++i)
        if (!is_finite(m.positions[i]))
            throw geometry_error{detail::joined(
                {"repair: vertex ", std::to_string(i), " is not finite; check the computation or file it comes from"})};
    return detail::mesh_repair{m, settings}.result();
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
