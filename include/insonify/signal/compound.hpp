#ifndef INSONIFY_SIGNAL_COMPOUND_HPP
#define INSONIFY_SIGNAL_COMPOUND_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/memo.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/probe/probe_lines.hpp>
#include <insonify/probe/transducer.hpp>
#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Spatial compounding: looks that are steered to several angles are averaged.
struct compound_settings {
    /// How many looks are acquired for a frame.
    enum class update_mode {
        all, ///< every look
        one, ///< one, which replaces the oldest look; the first frame has the look nearest to straight alone
    };
    std::uint32_t angles = 1;              ///< number of looks, 1 to 31; 1: no compounding
    float spread = 20_deg;                 ///< angle between the outermost looks, radians, at most 90_deg
    update_mode update = update_mode::all; ///< of a clip

    /// Angle of a look, radians: from -spread / 2 to spread / 2, at equal steps.
    float steering(std::uint32_t look) const {
        return angles < 2 ? 0 : spread * (static_cast<float>(look) / static_cast<float>(angles - 1) - 0.5F);
    }

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        if (angles < 1 || angles > 31)
            throw usage_error{"compound: `angles` is ", angles, "; it must be 1 to 31 looks"};
        check_angle(spread, "spread", 90_deg, "compound");
    }

    friend bool operator==(const compound_settings&, const compound_settings&) = default;
};

/// Acquires the looks of a frame and averages their amplitudes on the lines of the probe, weighted.
///
/// Amplitudes are averaged before log compression, so the mean level stays, and along scan lines, so the stages that
/// follow see ordinary lines of the probe. The weight of a look falls to 0 towards its sides: where it ends inside the
/// image there is no step.
///
/// The lines of the probe must be equally far apart on a plane or round face, as those of all arrays but radial ones.
template <transducer Probe>
class compounding {
  public:
    /// One frame of lines of the probe.
    ///
    /// Starts anew where the probe, `scan` or `settings` have changed since the last frame; call `reset` first where
    /// something else has. Averages do not depend on the order in which looks were acquired.
    /// @param scan     of the frame, with its samples; looks at an angle are longer
    /// @param acquire  acquire(number, look, scan, recycled): the amplitudes of one look, a `steered<Probe>`, as
    ///                 scan_lines after time gain; `recycled` are lines whose memory can be reused
    /// @throws usage_error  for a setting out of range, or a probe whose looks cannot be averaged
    template <exec::policy Policy, class Acquire>
    scan_lines operator()(const Policy& policy, const Probe& probe, const acquisition& scan,
                          const compound_settings& settings, const Acquire& acquire, scan_lines recycled = {}) {
        const auto make = [&](char&) {
            settings.check();
            probe.check();
            if (scan.samples == 0) throw usage_error{"compound: `samples` is 0; it must be that of the lines"};
            acquired_ = 0;
            while (looks_.size() > settings.angles) looks_.pop_back();
            while (looks_.size() < settings.angles) looks_.push_back({.probe = steered<Probe>{probe, 0}});
            for (std::uint32_t i = 0; i < settings.angles; ++i) assign(looks_[i], probe, scan, settings, i);
        };
        made_(make, key{probe}, scan.depth, scan.samples, scan.planes, settings);
        const bool all = settings.update == compound_settings::update_mode::all;
        const std::uint32_t begin = all ? 0 : next(), end = all ? settings.angles : begin + 1;
        for (std::uint32_t number = begin; number < end; ++number) {
            const look& own = looks_[number];
            recycled = acquire(number, own.probe, own.scan, std::move(recycled));
            if (settings.angles > 1) add(policy, looks_[number], recycled);
        }
        if (settings.angles > 1) {
            recycled.reshape(probe.lines, scan.samples, scan.depth);
            average(policy, recycled.values);
        }
        return recycled;
    }

    /// Forgets all looks.
    void reset() {
        acquired_ = 0;
        for (look& each : looks_) each.acquired = false;
    }

  private:
    // Where a look samples the lines of the probe: line i at sample k is its line i - shift, between two samples.
    struct row {
        float shift = 0;
        std::uint32_t sample = 0; // the upper one
        float fraction = 0;       // weight of the lower one
    };
    struct look {
        steered<Probe> probe;
        acquisition scan{};
        std::vector<row> rows{};
        std::vector<float> weighted{}, weights{}; // amplitudes on the lines of the probe, times the weight; the weight
        bool acquired = false;
    };
    using key = std::conditional_t<detail::comparable<Probe>, Probe, detail::probe_lines>; // can be compared
    static constexpr float min_weight = 1e-3F; // where only ends of looks meet, their mean counts

    static void assign(look& made, const Probe& probe, const acquisition& scan, const compound_settings& settings,
                       std::uint32_t number) {
        const float angle = settings.steering(number);
        made.probe = steered<Probe>{probe, angle};
        made.scan = scan;
        made.acquired = false;
        if (settings.angles == 1) return;
        made.probe.check();
        const float middle = 0.5F * static_cast<float>(probe.lines) - 0.5F;
        const auto located = [&](float line, float depth) {
            const vec3 point = probe.beam(line).at(depth);
            const vec2 at = made.probe.locate({point.x, point.z});
            return vec2{line - at.x, at.y};
        };
        // The same on every line?
        for (const float line : {0.0F, 0.25F * middle, 2 * middle})
            if (!(std::fabs(located(line, scan.depth).x - located(middle, scan.depth).x) < 0.1F) ||
                is_full_circle(probe))
                throw usage_error{
                    "compound: the lines of the probe must be equally far apart, on a plane or round face, "
                    "and no full circle"};
        if (angle != 0) {
            made.scan.depth = min(located(middle, scan.depth).y, max_scan_depth);
            made.scan.samples = static_cast<std::uint32_t>(
                std::ceil(static_cast<float>(scan.samples) * (made.scan.depth / scan.depth)));
        }
        made.rows.clear();
        const auto last = static_cast<float>(made.scan.samples > 1 ? made.scan.samples - 2 : 0);
        for (std::uint32_t k = 0; k < scan.samples; ++k) {
            const vec2 at =
                located(middle, (static_cast<float>(k) + 0.5F) * scan.depth / static_cast<float>(scan.samples));
            const float place = angle == 0 ? static_cast<float>(k)
                                           : at.y / made.scan.depth * static_cast<float>(made.scan.samples) - 0.5F;
            const float upper = clamp(std::floor(place), 0, last); // the lower sample exists also at the end
            made.rows.push_back({angle == 0 ? 0 : at.x, static_cast<std::uint32_t>(upper), clamp(place - upper, 0, 1)});
        }
        made.weighted.resize(std::size_t{probe.lines} * scan.samples);
        made.weights.resize(made.weighted.size());
    }

    // Looks in the order of their angles to the straight line.
    std::uint32_t next() const {
        const auto angles = static_cast<std::uint32_t>(looks_.size());
        const std::uint32_t turn = acquired_ % angles, away = (turn + 1) / 2, middle = (angles - 1) / 2;
        return turn % 2 == 1 ? middle + away : middle - away;
    }

    // Weight of a look at its (fractional) line: 1, falling to the minimum over an eighth of its width; 0 outside.
    static float weight(float line, float lines) {
        const float inside = min(line + 0.5F, lines - 0.5F - line);
        if (!(inside >= 0)) return 0;
        const float part = min(8 * inside / lines, 1);
        return max(part * part * (3 - 2 * part), min_weight);
    }

    template <class Policy>
    void add(const Policy& policy, look& own, const scan_lines& amplitudes) {
        const std::size_t samples = own.rows.size(), stride = own.scan.samples;
        if (amplitudes.count != own.probe.lines || amplitudes.samples != stride ||
            amplitudes.values.size() != amplitudes.count * stride)
            throw usage_error{"compound: a look must have the lines of the probe and the samples that were requested"};
        const auto lines = static_cast<float>(amplitudes.count);
        const std::size_t below = stride > 1 ? 1 : 0, beside = amplitudes.count > 1 ? stride : 0;
        const float last = max(lines - 2, 0);
        const bool straight = own.probe.steering == 0;
        exec::for_each_in_blocks(policy, amplitudes.count, 8, 3 * static_cast<float>(samples), [&](std::size_t line) {
            float* const to = own.weighted.data() + line * samples;
            float* const weights = own.weights.data() + line * samples;
            for (std::size_t k = 0; k < samples; ++k) {
                const row& at = own.rows[k];
                const float place = static_cast<float>(line) - at.shift;
                const float fraction = weights[k] = straight ? 1.0F : weight(place, lines);
                to[k] = 0;
                if (fraction == 0) continue;
                const float left = clamp(std::floor(place), 0, last), part = clamp(place - left, 0, 1);
                const float* const from =
                    amplitudes.values.data() + static_cast<std::size_t>(left) * stride + at.sample;
                const float here = multiply_add(at.fraction, from[below] - from[0], from[0]);
                const float next = multiply_add(at.fraction, from[beside + below] - from[beside], from[beside]);
                to[k] = fraction * multiply_add(part, next - here, here);
            }
        });
        own.acquired = true;
        ++acquired_;
    }

    template <class Policy>
    void average(const Policy& policy, std::vector<float>& values) const {
        constexpr std::size_t block = 4096;
        exec::for_each_block(
            policy, values.size(), block, 0.3F * static_cast<float>(looks_.size()),
            [&](std::size_t begin, std::size_t end) {
                float* const to = values.data() + begin;
                float weights[block] = {};
                std::fill_n(to, end - begin, 0.0F);
                for (const look& each : looks_) {
                    if (!each.acquired) continue;
                    const float *const from = each.weighted.data() + begin, *const own = each.weights.data() + begin;
                    for (std::size_t i = 0; i < end - begin; ++i) to[i] += from[i];
                    for (std::size_t i = 0; i < end - begin; ++i) weights[i] += own[i];
                }
                // Where no look has a weight, both sums are 0.
                for (std::size_t i = 0; i < end - begin; ++i) to[i] /= max(weights[i], min_weight);
            });
    }

    std::vector<look> looks_{};
    std::uint32_t acquired_ = 0; // since the start
    // For which the looks were made: probe, depth, samples, planes, settings.
    detail::memo<char, key, float, std::uint32_t, std::uint32_t, compound_settings> made_{};
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
