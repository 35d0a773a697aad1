#ifndef INSONIFY_SCENE_KEPT_MAP_HPP
#define INSONIFY_SCENE_KEPT_MAP_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/any_policy.hpp>
#include <insonify/scene/inverse_map.hpp>
#include <insonify/scene/inverse_tetrahedra.hpp>
#include <memory>
#include <type_traits>

namespace insonify::inline INSONIFY_ABI::detail {

/// The deformation map of a scene, of any type, as a value. Another map of the same type takes the memory of the former one.
class kept_map {
  public:
    kept_map() = default;
    kept_map(kept_map&&) = default;
    kept_map& operator=(kept_map&&) = default;
    kept_map(const kept_map& other) : map_{other.map_ ? other.map_->copy() : nullptr} {}
    kept_map& operator=(const kept_map& other) {
        if (this != &other) map_ = other.map_ ? other.map_->copy() : nullptr;
        return *this;
    }
    ~kept_map() = default;

    template <deformation_map Map>
    void assign(const Map& map) {
        if constexpr (std::is_copy_assignable_v<Map>) {
            if (map_ && map_->type() == type_of<Map>()) {
                static_cast<typed<Map>&>(*map_).map = map;
                return;
            }
        } else if constexpr (std::is_nothrow_copy_constructible_v<Map>) { // a lambda that captures
            if (map_ && map_->type() == type_of<Map>()) {
                Map& own = static_cast<typed<Map>&>(*map_).map;
                std::destroy_at(&own);
                std::construct_at(&own, map);
                return;
            }
        }
        map_ = std::make_unique<typed<Map>>(map);
    }
    void clear() { map_.reset(); }
    /// Whether there is none: all is at rest.
    bool empty() const { return map_ == nullptr; }

    /// See `invert_map`.
    void invert(const any_policy<false>& policy, const displacement_lattice& where, float* nodes) const {
        map_->invert_at(policy, where, nodes);
    }
    /// The point at rest of the tissue that is now at a point. @throws geometry_error  where the map folds over
    vec3 rest_of(vec3 now) const {
        vec3 rest = now;
        if (map_ && !map_->rest_at(now, rest)) throw_folded(now);
        return rest;
    }

  private:
    struct any_map {
        any_map() = default;
        any_map(const any_map&) = delete;
        any_map& operator=(const any_map&) = delete;
        virtual ~any_map() = default;
        virtual std::unique_ptr<any_map> copy() const = 0;
        virtual const void* type() const = 0;
        virtual void invert_at(const any_policy<false>& policy, const displacement_lattice& where,
                               float* nodes) const = 0;
        virtual bool rest_at(vec3 now, vec3& rest) const = 0;
    };
    template <class Map>
    static const void* type_of() {
        static constexpr char address = 0;
        return &address;
    }
    template <class Map>
    struct typed final : any_map {
        Map map;
        explicit typed(const Map& own) : map(own) {}
        std::unique_ptr<any_map> copy() const override { return std::make_unique<typed>(map); }
        const void* type() const override { return type_of<Map>(); }
        void invert_at(const any_policy<false>& policy, const displacement_lattice& where,
                       float* nodes) const override {
            invert_map(policy, map, where, nodes);
        }
        bool rest_at(vec3 now, vec3& rest) const override { return find_rest(map, now, rest); }
    };

    std::unique_ptr<any_map> map_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
