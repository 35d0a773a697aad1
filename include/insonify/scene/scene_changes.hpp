#ifndef INSONIFY_SCENE_SCENE_CHANGES_HPP
#define INSONIFY_SCENE_SCENE_CHANGES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/scene/scene.hpp>
#include <atomic>

namespace insonify::inline INSONIFY_ABI {

inline object_id scene::add(mesh surface, const medium& inside, object_settings settings) {
    const object_id id{next_id_};
    detail::check_object(surface, inside, settings, id);
    states_.resize(objects_.size() + 1);
    states_.back().volume = enclosed_volume(surface);
    objects_.push_back({.id = id,
                        .name = std::move(settings.name),
                        .surface = std::move(surface),
                        .inside = inside,
                        .at = settings.at,
                        .priority = settings.priority,
                        .fibres = settings.fibres,
                        .crease_angle = settings.crease_angle});
    ++next_id_;
    built_ = false;
    return id;
}

inline void scene::set_background_fibres(vec3 along, vec3 flat) {
    if (!is_finite(along) || !is_finite(flat) || length(cross(along, flat)) <= 1e-3F * length(along) * length(flat))
        throw usage_error{"set_background_fibres: the directions must be finite, not 0 and not parallel, such as "
                          "{1, 0, 0} and {0, 0, 1}"};
    background_axes_ = detail::aligned(mat3{normalize(along), normalize(cross(flat, along)), normalize(flat)}, along);
    place_background();
}

inline void scene::set_medium(object_id id, const medium& inside) {
    const std::size_t index = index_of(id);
    detail::check_medium(inside, "set_medium: the medium of " + detail::named(objects_[index].name, id));
    const medium before = std::exchange(objects_[index].inside, inside);
    try {
        if (built_) media_ = detail::distinct_media(background_, objects_, states_);
    } catch (...) {
        objects_[index].inside = before;
        throw;
    }
    if (built_) states_[index].place_structure(objects_[index], states_[index].rest);
    expire();
}

template <class Which>
void scene::read_positions(const threads& policy, const Which& which) {
    const object* refused = nullptr;
    for (std::size_t i = 0; i < objects_.size(); ++i)
        if (which(states_[i]) && !states_[i].read(policy, objects_[i]) && refused == nullptr) refused = &objects_[i];
    if (refused == nullptr) return;
    const std::size_t vertex = detail::find_not_finite(refused->surface.positions);
    for (std::size_t i = 0; i < objects_.size(); ++i)
        if (which(states_[i])) states_[i].refuse(objects_[i]);
    detail::refuse_frame(*refused, vertex);
}

inline void scene::follow(const threads& policy) {
    require_built();
    read_positions(policy, [](const detail::object_state& state) { return state.moved; });
    constexpr std::uint32_t updates_worth_a_tree = 2;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
        detail::object_state& state = states_[i];
        if (state.moved) {
            state.accept(objects_[i]);
            views_.reset_slices();
        } else if (state.tree_is_current || ++state.updates_at_rest < updates_worth_a_tree) {
            continue;
        } else {
            state.update_tree(policy, objects_[i]);
        }
        expire();
    }
}

inline void scene::rebuild(const threads& policy) {
    read_positions(policy, [](const detail::object_state& state) { return state.handed_out(); });
    std::vector<detail::object_state> states(objects_.size());
    for (std::size_t i = 0; i < objects_.size(); ++i) states[i].build(policy, objects_[i], states_[i].rest);
    std::vector<std::uint32_t> by_rank = detail::ranked(objects_);
    std::vector<medium> media = detail::distinct_media(background_, objects_, states);
    for (std::size_t i = 0; i < objects_.size(); ++i) states[i].keep(states_[i]);
    states_ = std::move(states);
    by_rank_ = std::move(by_rank);
    media_ = std::move(media);
    place_background();
    built_ = true;
}

template <class Map, class Follows>
void scene::deform_those(const threads& policy, const Map& map, const Follows& follows) {
    require_built();
    try {
        read_positions(policy, [](const detail::object_state& state) { return state.moved; });
        detail::check_map(policy, map, box());
        std::atomic<bool> any_moved{false};
        exec::for_each_block(policy, objects_.size(), 1, 100e3F, [&](std::size_t i, std::size_t) {
            if (detail::deform_object(policy, objects_[i], states_[i], follows(objects_[i].id) ? &map : nullptr))
                any_moved.store(true, std::memory_order_relaxed);
        });
        if (any_moved.load(std::memory_order_relaxed)) views_.reset_slices();
        deformation_.assign(map);
    } catch (...) {
        for (std::size_t i = 0; i < objects_.size(); ++i)
            detail::deform_object<threads, Map>(policy, objects_[i], states_[i], nullptr);
        deformation_.clear();
        expire();
        throw;
    }
    expire();
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
