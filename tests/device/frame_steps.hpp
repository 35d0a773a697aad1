#ifndef INSONIFY_TESTS_DEVICE_FRAME_STEPS_HPP
#define INSONIFY_TESTS_DEVICE_FRAME_STEPS_HPP

#include <insonify/insonify.hpp>
#include <utility>
#include <vector>

/// In the order in which they are done.
enum class frame_step { find_layers, find_profile, find_sound, find_means, find_gains, emit };
inline constexpr frame_step all_frame_steps[] = {frame_step::find_layers, frame_step::find_profile,
                                                 frame_step::find_sound,  frame_step::find_means,
                                                 frame_step::find_gains,  frame_step::emit};

/// The frame that `trace` makes by default, with layers found by rays, as steps of which each is a function of one index: a loop
/// on the host, a kernel on a device. Trivially copyable.
template <insonify::acoustic_model Model>
struct frame_steps {
    using sample = typename Model::sample_type;

    insonify::detail::aperture_view shading;
    Model model{};
    insonify::view<insonify::line_room> rooms{};          ///< for each line of each plane
    insonify::view<insonify::line_room> turned_rooms{};   ///< for each line of the fan in each direction and plane
    insonify::view<insonify::detail::found_line> found{}; ///< by line and plane
    insonify::view<sample> of_planes{};                   ///< room for the samples of one plane, by line
    insonify::view<sample> samples{};                     ///< by line
    insonify::view<std::uint32_t> too_small{}; ///< of each line and plane, of each turned line: whether its room was

    /// How many indices a step has.
    INSONIFY_FN std::size_t count(frame_step one) const {
        switch (one) {
        case frame_step::find_sound:
            return turned_lines();
        case frame_step::find_means:
            return std::size_t{shading.frame.planes} * shading.steps * groups_of_points();
        case frame_step::emit:
            return shading.frame.count();
        default:
            return lines_of_planes();
        }
    }
    INSONIFY_FN void run(frame_step one, std::size_t i) const {
        switch (one) {
        case frame_step::find_layers:
            return find_layers(i);
        case frame_step::find_profile:
            return find_profile(i);
        case frame_step::find_sound:
            return find_sound(i);
        case frame_step::find_means:
            return find_means(i);
        case frame_step::find_gains:
            return find_gains(i);
        case frame_step::emit:
            return emit(i);
        }
    }

    INSONIFY_FN std::size_t lines_of_planes() const {
        return std::size_t{shading.frame.count()} * shading.frame.planes;
    }
    INSONIFY_FN std::size_t turned_lines() const {
        return std::size_t{shading.directions} * shading.frame.planes * shading.fan.size();
    }

  private:
    INSONIFY_FN std::size_t groups_of_points() const {
        return (shading.points.count + shading.points_at_once - 1) / shading.points_at_once;
    }

    INSONIFY_FN void find_layers(std::size_t i) const {
        const auto [line, plane] = split(i, shading.frame.planes);
        found[i] = insonify::detail::find_line(shading.scene, shading.frame.line(line, plane), shading.frame.max_depth,
                                               true, {}, rooms[i]);
        too_small[i] = found[i].layers.empty();
    }
    INSONIFY_FN void find_profile(std::size_t i) const {
        const auto [line, plane] = split(i, shading.frame.planes);
        shading.find_profile(line, plane, found[i].layers, model);
    }
    INSONIFY_FN void find_sound(std::size_t i) const {
        const auto [row, line] = split(i, shading.fan.size());
        const auto [direction, plane] = split(row, shading.frame.planes);
        const std::uint32_t nearest = shading.points.line_of(shading.points.nearest(line));
        too_small[lines_of_planes() + i] =
            !shading.find_sound(direction, line, plane, found[nearest * shading.frame.planes + plane].behind_face,
                                model, {}, turned_rooms[i]);
    }
    INSONIFY_FN void find_means(std::size_t i) const {
        const auto [row, group] = split(i, groups_of_points());
        shading.find_means(row / shading.steps, row % shading.steps, group * shading.points_at_once);
    }
    INSONIFY_FN void find_gains(std::size_t i) const {
        const auto [line, plane] = split(i, shading.frame.planes);
        shading.find_gains(line, plane);
    }
    INSONIFY_FN void emit(std::size_t i) const {
        const auto line = static_cast<std::uint32_t>(i);
        const std::size_t count = shading.frame.samples;
        const insonify::view<sample> out{samples.data() + i * count, count};
        insonify::detail::sum_planes(
            shading.frame, line, 1, insonify::view<sample>{of_planes.data() + i * count, count},
            [&](std::size_t) { return out; },
            [&](std::uint32_t plane, insonify::view<sample> of_plane) {
                insonify::line_task task = insonify::detail::task_of(shading.frame, shading.scene, line, plane);
                task.line.gains = shading.gains.of_line(line, plane);
                task.apply(insonify::exec::sequenced_policy{}, model, found[i * shading.frame.planes + plane].layers,
                           of_plane);
            });
    }

    struct two_numbers {
        std::uint32_t first, second;
    };
    INSONIFY_FN static two_numbers split(std::size_t i, std::size_t by) {
        return {static_cast<std::uint32_t>(i / by), static_cast<std::uint32_t>(i % by)};
    }
};

/// The memory of `frame_steps`, and what they read that is made on the host.
template <insonify::acoustic_model Model>
class frame_memory {
  public:
    using steps = frame_steps<Model>;

    steps prepare(const insonify::scene& body, const insonify::transducer auto& probe, const Model& model,
                  const insonify::acquisition& scan) {
        using namespace insonify;
        probe_.assign(probe);
        const detail::frame_view frame =
            plan_.view_of(exec::par, probe_, pose{}, model, scan, scan.samples, body.media());
        detail::line_fan fan;
        fan.assign(probe_);
        shading_.assign(probe_.settings(), fan, beam_of(probe, scan.depth));
        steps all{.shading = shading_.prepare(body.view_for_rays(exec::par), frame, straight_lines{}.directions),
                  .model = model};
        make_rooms(all.lines_of_planes(), memory_, rooms_);
        make_rooms(all.turned_lines(), turned_memory_, turned_rooms_);
        found_.resize(rooms_.size());
        of_planes_.resize(std::size_t{probe.lines} * frame.samples);
        samples_.resize(of_planes_.size());
        too_small_.resize(rooms_.size() + turned_rooms_.size());
        all.rooms = rooms_;
        all.turned_rooms = turned_rooms_;
        all.found = found_;
        all.of_planes = of_planes_;
        all.samples = samples_;
        all.too_small = too_small_;
        return all;
    }

  private:
    static void make_rooms(std::size_t count, std::vector<insonify::detail::line_memory>& memory,
                           std::vector<insonify::line_room>& rooms) {
        memory.resize(count);
        rooms.clear();
        for (insonify::detail::line_memory& one : memory) {
            one.grow();
            rooms.push_back(one.room());
        }
    }

    insonify::detail::probe_lines probe_{};
    insonify::detail::frame_plan<Model> plan_{};
    insonify::detail::aperture_shading shading_{};
    std::vector<insonify::detail::line_memory> memory_{}, turned_memory_{};
    std::vector<insonify::line_room> rooms_{}, turned_rooms_{};
    std::vector<insonify::detail::found_line> found_{};
    std::vector<typename Model::sample_type> of_planes_{}, samples_{};
    std::vector<std::uint32_t> too_small_{};
};

#endif
