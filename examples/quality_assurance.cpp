// Quality assurance as for a real scanner: image a phantom of known content, measure the echoes and compare. Prints a
// table, writes the images, and fails if a value is out of tolerance.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "quality_phantom.hpp"
#include <cmath>
#include <cstdio>
#include <string>

using namespace insonify;

std::string text(const char* format, float number) {
    char buffer[40];
    std::snprintf(buffer, sizeof buffer, format, static_cast<double>(number));
    return buffer;
}

/// Prints each value beside its tolerance and counts those that are out of it.
struct quality_table {
    int out = 0;

    void row(const std::string& what, float measured, const std::string& stated, bool good) {
        std::printf("  %-46s %8.3f   %-18s %s\n", what.c_str(), static_cast<double>(measured), stated.c_str(),
                    good ? "ok" : "OUT");
        out += good ? 0 : 1;
    }
    void within(const std::string& what, float measured, float stated, float allowed) {
        row(what, measured, text("%.3f", stated) + text(" +- %.3f", allowed), std::fabs(measured - stated) <= allowed);
    }
    void at_least(const std::string& what, float measured, float bound) {
        row(what, measured, text("at least %g", bound), measured >= bound);
    }
    void at_most(const std::string& what, float measured, float bound) {
        row(what, measured, text("at most %g", bound), measured <= bound);
    }
};

/// Envelopes of slices 1 mm apart around y. Targets are the same in all slices; each has speckle of its own.
/// @param picture  file for the image of the first slice
/// @param sound    how it travels
template <transducer Probe>
std::vector<scan_lines> scan(const scene& body, const Probe& probe, float y, int slices, const acquisition& how,
                             const std::string& picture, const straight_lines& sound = {}) {
    std::vector<scan_lines> all;
    for (int i = 0; i < slices; ++i) {
        const pose at{.translation = {0, y + static_cast<float>(i - slices / 2) * 1_mm, 0}};
        physical<> model{.bandwidth = pulse_bandwidth::narrow}; // attenuation of gels is stated for single frequencies
        model.scattering.seed = static_cast<std::uint32_t>(i + 1);
        iq_lines iq = trace(exec::par_unseq, body, probe, at, model, how, sound);
        iq = convolve(exec::par_unseq, std::move(iq), nominal_pulse(probe), probe);
        all.push_back(envelope(exec::par_unseq, iq));
    }
    const scan_lines greys = log_compress(exec::par_unseq, tgc(exec::par_unseq, all[0], probe.frequency));
    write_png(picture, scan_convert(exec::par_unseq, greys, probe, {.size = {768, 0}}));
    return all;
}

/// The rms envelope of all slices as a function of the point {x, z}, linear between lines and samples.
template <transducer Probe>
struct wire_finder {
    const std::vector<scan_lines>& slices;
    const Probe& probe;

    float operator()(vec2 point) const {
        const vec2 place = probe.locate(point);
        const float sample = place.y / slices[0].depth * static_cast<float>(slices[0].samples) - 0.5F;
        const vec2 weight{place.x - std::floor(place.x), sample - std::floor(sample)};
        const auto i = static_cast<std::uint32_t>(place.x), k = static_cast<std::uint32_t>(sample);
        float power = 0;
        for (const scan_lines& lines : slices) {
            const float here = (1 - weight.y) * lines(i, k) + weight.y * lines(i, k + 1);
            const float next = (1 - weight.y) * lines(i + 1, k) + weight.y * lines(i + 1, k + 1);
            const float value = (1 - weight.x) * here + weight.x * next;
            power += value * value;
        }
        return std::sqrt(power / static_cast<float>(slices.size()));
    }

    /// The image of a wire: the middle of its -6 dB points, and their distance across and along the beam.
    struct spot {
        vec2 middle{0, 0};
        vec2 width{0, 0};
    };
    spot find(vec2 expected) const {
        vec2 peak = expected;
        for (int x = -20; x <= 20; ++x)
            for (int z = -20; z <= 20; ++z)
                if (const vec2 near_by = expected + 20_um * vec2{x, z}; (*this)(near_by) > (*this)(peak))
                    peak = near_by;
        const vec3 direction = probe.beam(probe.locate(expected).x).direction;
        const vec2 along{direction.x, direction.z}, across{direction.z, -direction.x};
        const auto reach = [&](vec2 aside) {
            float distance = 0;
            while ((*this)(peak + distance * aside) > 0.5F * (*this)(peak)) distance += 0.2_um;
            return distance;
        };
        const float left = reach(-across), right = reach(across), up = reach(-along), down = reach(along);
        return {peak + 0.5F * (right - left) * across + 0.5F * (down - up) * along, {left + right, up + down}};
    }

    /// The dip between the echoes of two wires in dB, relative to the weaker of the two peaks.
    float dip(vec3 from, vec3 to) const {
        const auto value = [&](int percent) {
            const vec3 point = from + 0.01F * static_cast<float>(percent) * (to - from);
            return (*this)({point.x, point.z});
        };
        float before = 0, behind = 0;
        for (int i = 0; i <= 50; ++i) before = max(before, value(i)), behind = max(behind, value(100 - i));
        return 20 * std::log10(min(before, behind) / value(50));
    }
};

/// Wires: position, resolution, and which pairs are resolved.
template <transducer Probe>
void check_wires(quality_table& table, const std::vector<scan_lines>& slices, const Probe& probe, float scale) {
    const wire_finder<Probe> seen{slices, probe};
    const float lateral = 0.92F * display_speed / probe.frequency * probe.fnumber;    // at the focus
    const float axial = 0.441F * display_speed / (probe.bandwidth * probe.frequency); // of a Gaussian pulse
    float along = 0;
    for (const vec2 wire : quality::wires) {
        const auto spot = seen.find(scale * wire);
        table.within("wire: x, mm", spot.middle.x / 1_mm, scale * wire.x / 1_mm, 0.05F);
        table.within("wire: z, mm", spot.middle.y / 1_mm, scale * wire.y / 1_mm, 0.05F);
        along += spot.width.y / static_cast<float>(std::size(quality::wires));
    }
    const float across = seen.find(scale * quality::focused_wire).width.x;
    table.within("-6 dB width of the focused wire, mm", across / 1_mm, lateral / 1_mm, 0.05F * lateral / 1_mm);
    table.within("-6 dB length of wires, mean, mm", along / 1_mm, axial / 1_mm, 0.03F * axial / 1_mm);

    // Two Gaussian echoes in phase at a spacing of q widths sum to 2 * 0.5^(q^2) midway: -6 dB at q = sqrt(2).
    const auto check_pair = [&](const quality::wire_pair& two, vec3 direction, float width, const char* how) {
        const pose at = quality::on_beam(probe, scale * two.middle);
        const float spacing = scale * two.spacing, widths = spacing / width;
        const vec3 half = 0.5F * spacing * direction;
        const float dip = seen.dip(at.point(-half), at.point(half));
        const std::string name = text("wires %g mm ", spacing / 1_mm) + how + text(" (%.2f widths): dip, dB", widths);
        widths < 1 ? table.at_most(name, dip, 6) : table.at_least(name, dip, 6);
    };
    for (const quality::wire_pair& two : quality::lateral_pairs) check_pair(two, {1, 0, 0}, lateral, "across");
    for (const quality::wire_pair& two : quality::axial_pairs) check_pair(two, {0, 0, 1}, axial, "along");
}

/// Statistics of the samples of a region.
struct speckle {
    double n = 0, sum = 0, power = 0, depths = 0, squares = 0, decibels = 0, products = 0;

    void add(float depth, float amplitude) {
        const double a = static_cast<double>(amplitude), z = static_cast<double>(depth), level = 20 * std::log10(a);
        ++n, sum += a, power += a * a, depths += z, squares += z * z, decibels += level, products += z * level;
    }
    float level() const { return static_cast<float>(10 * std::log10(power / n)); }
    float signal_to_noise() const { return static_cast<float>(1 / std::sqrt(power * n / (sum * sum) - 1)); }
    float decibels_per_metre() const { // linear regression of level on depth
        return static_cast<float>((n * products - depths * decibels) / (n * squares - depths * depths));
    }
};

/// Of the samples between two depths for which inside(fraction of the field, point {x, z}); attenuation is compensated.
template <transducer Probe, class Inside>
speckle speckle_in(const std::vector<scan_lines>& slices, const Probe& probe, const medium& gel, vec2 depths,
                   const Inside& inside) {
    speckle all;
    const float spacing = slices[0].depth / static_cast<float>(slices[0].samples);
    for (auto k = static_cast<std::uint32_t>(depths.x / spacing); static_cast<float>(k) * spacing < depths.y; ++k) {
        const float depth = (static_cast<float>(k) + 0.5F) * spacing;
        const float gain = std::pow(10.0F, echo_loss(gel, probe.frequency) * depth / 20);
        for (std::uint32_t i = 0; i < probe.lines; ++i) {
            const vec3 at = probe.beam(static_cast<float>(i)).at(depth);
            if (!inside(aperture_fraction(static_cast<float>(i), probe.lines), vec2{at.x, at.z})) continue;
            for (const scan_lines& lines : slices) all.add(depth, gain * lines(i, k));
        }
    }
    return all;
}

/// Both kinds of gel: level, statistics and attenuation of the speckle, and contrast of the cysts.
template <transducer Probe>
void check_gel(quality_table& table, const std::vector<scan_lines>& slices, const Probe& probe, float scale) {
    for (const float side : {-1.0F, 1.0F}) {
        const medium& gel = side < 0 ? tissue::tmm_low : tissue::tmm_high;
        const std::string name = side < 0 ? "gel of 0.5: " : "gel of 0.7: ";
        const float loss = echo_loss(gel, probe.frequency) * 1_cm;
        const auto beside_cysts = [&](float fraction, vec2) {
            return side * fraction > 0.03F && side * fraction < 0.15F;
        };
        const speckle clear = speckle_in(slices, probe, gel, scale * vec2{5_mm, 45_mm}, beside_cysts);
        table.within(name + "level, dB", clear.level(), -55, 0.3F);
        table.within(name + "mean over deviation", clear.signal_to_noise(), 1.913F, 0.02F * 1.913F);
        table.within(name + "attenuation, dB/cm", loss - clear.decibels_per_metre() * 1_cm, loss, 0.02F * loss);
        for (const quality::target& cyst : quality::cysts) {
            if (side * cyst.centre.x < 0) continue;
            const float depth = probe.locate(scale * cyst.centre).y;
            const float radius = scale * cyst.radius - beam_of(probe, slices[0].depth).lateral_width(depth);
            const auto in_cyst = [&](float, vec2 at) { return length(at - scale * cyst.centre) < radius; };
            const speckle inside = speckle_in(slices, probe, gel, depth + radius * vec2{-1, 1}, in_cyst);
            table.at_most(name + text("cyst of %g mm, dB", 2 * scale * cyst.radius / 1_mm),
                          inside.level() - clear.level(), -28);
        }
    }
}

/// Levels of the grey-scale targets relative to the gel beside them at the same depth.
template <transducer Probe>
void check_targets(quality_table& table, const std::vector<scan_lines>& slices, const Probe& probe, float scale) {
    const beam_model beam = beam_of(probe, slices[0].depth);
    for (const quality::target& target : quality::targets) {
        const float depth = probe.locate(scale * target.centre).y, margin = beam.lateral_width(depth);
        const float radius = scale * target.radius - margin;
        const auto in_target = [&](float, vec2 at) { return length(at - scale * target.centre) < radius; };
        const auto in_none = [&](float, vec2 at) {
            float distance = FLT_MAX;
            for (const quality::target& each : quality::targets)
                distance = min(distance, length(at - scale * each.centre) - scale * each.radius);
            return distance > margin;
        };
        const vec2 depths = depth + radius * vec2{-1, 1};
        const speckle inside = speckle_in(slices, probe, tissue::tmm_low, depths, in_target);
        const speckle beside = speckle_in(slices, probe, tissue::tmm_low, depths, in_none);
        // Three standard errors of the mean over all resolution cells, each of area 2 pi sigma_x sigma_z.
        const float cell = 2 * pi * beam.lateral_sigma(depth) * nominal_pulse(probe).sigma_z(probe.frequency);
        const float cells = pi * radius * radius / cell * static_cast<float>(slices.size());
        table.within("target " + text("%g mm deep, dB", scale * target.centre.y / 1_mm),
                     inside.level() - beside.level(), target.level_db, 13 / std::sqrt(cells));
    }
}

/// @param rays  per line, so that two rays hit the front of a wire
/// @return the number of values out of tolerance
template <transducer Probe>
int examine(const std::string& name, const Probe& probe, float scale, float rays) {
    std::printf("%s, %g MHz\n", name.c_str(), static_cast<double>(probe.frequency / 1_MHz));
    const scene body = quality_phantom(probe, scale).build(exec::par);
    const acquisition usual{.depth = scale * 50_mm}, finer{.depth = usual.depth, .samples = 3072};
    const refined<Probe> lines{probe, rays_per_line(probe, usual.depth)}, finer_lines{probe, rays};
    const auto picture = [&](const char* part) { return "quality_" + name + "_" + part + ".png"; };
    quality_table table;
    check_wires(table, scan(body, finer_lines, quality::wires_at, 8, finer, picture("wires")), finer_lines, scale);
    // Each gel as if it were alone: the aperture would see the other gel as well, and the cysts.
    check_gel(table, scan(body, lines, quality::cysts_at, 8, usual, picture("cysts"), {.directions = 1}), lines, scale);
    check_targets(table, scan(body, lines, quality::targets_at, 16, usual, picture("targets")), lines, scale);
    return table.out;
}

int main() {
    const linear_array linear{.focus = 30_mm, .bandwidth = 0.6F};
    const convex_array convex{.focus = 60_mm, .bandwidth = 0.6F};
    const int out = examine("linear", linear, 1, 8) + examine("convex", convex, 2, 16);
    std::printf("%d numbers are out\n", out);
    return out == 0 ? 0 : 1;
}
