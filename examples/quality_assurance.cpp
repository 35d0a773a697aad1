// What a physicist does to a scanner once a year: scans a phantom whose content is known (quality_phantom.hpp), measures
// the echoes and compares. Prints a table, draws what it sees, and fails where a number is out.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "quality_phantom.hpp"
#include <cstdio>
#include <string>

using namespace insonify;

/// Prints each number beside what it must be, and counts those that are out.
struct quality_table {
    int out = 0;

    void print(const std::string& what, float measured, const char* relation, float stated, float allowed, bool good) {
        std::printf("  %-38s %9.3f  %2s %8.3f", what.c_str(), static_cast<double>(measured), relation,
                    static_cast<double>(stated));
        if (allowed > 0)
            std::printf(" +- %5.3f", static_cast<double>(allowed));
        else
            std::printf("         ");
        std::printf("   %s\n", good ? "ok" : "NOT OK");
        out += good ? 0 : 1;
    }
    void within(const std::string& what, float measured, float stated, float allowed) {
        print(what, measured, "", stated, allowed, std::fabs(measured - stated) <= allowed);
    }
    void at_least(const std::string& what, float measured, float bound) {
        print(what, measured, ">=", bound, 0, measured >= bound);
    }
    void at_most(const std::string& what, float measured, float bound) {
        print(what, measured, "<=", bound, 0, measured <= bound);
    }
};

/// The envelopes of slices a millimetre apart about y: what runs along y is the same in all, the speckle is not. The first
/// is drawn as well.
template <transducer Probe>
std::vector<scan_lines> scan(const scene& body, const Probe& probe, float y, int slices, const acquisition& how,
                             const std::string& picture) {
    std::vector<scan_lines> all;
    for (int i = 0; i < slices; ++i) {
        const pose at{.translation = {0, y + (static_cast<float>(i) - 0.5F * static_cast<float>(slices)) * 1_mm, 0}};
        iq_lines iq = trace(exec::par_unseq, body, probe, at, physical<>{}, how);
        iq = convolve(exec::par_unseq, std::move(iq), nominal_pulse(probe), probe);
        all.push_back(envelope(exec::par_unseq, iq));
    }
    const scan_lines greys = log_compress(exec::par_unseq, tgc(exec::par_unseq, all[0], probe.frequency));
    write_png(picture + ".png", scan_convert(exec::par_unseq, greys, probe, {.size = {768, 0}}));
    return all;
}

/// One picture out of slices: the root of their mean power.
scan_lines mean_of(std::vector<scan_lines> slices) {
    scan_lines& mean = slices[0];
    for (std::size_t i = 0; i < mean.values.size(); ++i) {
        float power = 0;
        for (const scan_lines& each : slices) power += each.values[i] * each.values[i];
        mean.values[i] = std::sqrt(power / static_cast<float>(slices.size()));
    }
    return std::move(mean);
}

/// Lines with which a wire is sought: its picture, and what lies between two of them.
template <transducer Probe>
struct finder {
    const scan_lines& lines;
    const Probe& probe;
    float sample = lines.depth / static_cast<float>(lines.samples); ///< metres

    float operator()(int line, int k) const {
        return lines(static_cast<std::uint32_t>(line), static_cast<std::uint32_t>(k));
    }
    int line_at(vec2 point) const { return static_cast<int>(std::lround(probe.locate(point).x)); }
    int sample_at(vec2 point) const { return static_cast<int>(probe.locate(point).y / sample); }

    /// The picture of a point: where its middle is, x and z, and its -6 dB width across the beam and along it.
    struct spot {
        vec2 at{0, 0};
        vec2 width{0, 0};
    };
    spot find(vec2 point) const {
        const float spacing = line_spacing(probe, probe.locate(point).y);
        const int across = static_cast<int>(0.4_mm / spacing), along = static_cast<int>(0.4_mm / sample);
        int line = line_at(point), k = sample_at(point);
        for (int x = line_at(point) - across; x <= line_at(point) + across; ++x)
            for (int z = sample_at(point) - along; z <= sample_at(point) + along; ++z)
                if ((*this)(x, z) > (*this)(line, k)) line = x, k = z;
        const auto half_height = [](const auto& value, int peak, int step) { // linear between two values
            int i = peak;
            while (value(i) > 0.5F * value(peak)) i += step;
            const float beyond = (0.5F * value(peak) - value(i)) / (value(i - step) - value(i));
            return static_cast<float>(i) - static_cast<float>(step) * beyond;
        };
        const auto row = [&](int x) { return (*this)(x, k); };
        const auto column = [&](int z) { return (*this)(line, z); };
        const float left = half_height(row, line, -1), right = half_height(row, line, 1);
        const float top = half_height(column, k, -1), bottom = half_height(column, k, 1);
        const vec3 middle = probe.beam(0.5F * (left + right)).at((0.5F * (top + bottom) + 0.5F) * sample);
        return {{middle.x, middle.z}, {(right - left) * spacing, (bottom - top) * sample}};
    }

    /// Along a row through two wires, and along a column: the highest values nearby, so that neither need be met exactly.
    std::vector<float> across(vec2 from, vec2 to) const {
        std::vector<float> profile;
        for (int line = line_at(from); line <= line_at(to); ++line) {
            profile.push_back(0);
            for (int k = sample_at(from) - 3; k <= sample_at(from) + 3; ++k)
                profile.back() = greater(profile.back(), (*this)(line, k));
        }
        return profile;
    }
    std::vector<float> along(vec2 from, vec2 to) const {
        std::vector<float> profile;
        for (int k = sample_at(from); k <= sample_at(to); ++k) profile.push_back((*this)(line_at(from), k));
        return profile;
    }
};
