// Plans collision-free motions from C++17: clearway.h with owners, views and results.
//
// Units: metres, radians, seconds. Threads: as clearway.h says. What calls return is a
// result<T>: a T or an error; nothing throws unless value() is called on an error.
#ifndef CLEARWAY_HPP
#define CLEARWAY_HPP

#include "clearway.h"

#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace clearway {

using sample = clearway_sample;
using leg = clearway_leg;
using box = clearway_box;
using exceeds = clearway_exceeds;
using summary = clearway_summary;
using status = clearway_status;

/// Values that follow each other, owned by somebody else.
template <typename T>
class view {
public:
    constexpr view(const T* data, std::size_t size) noexcept : data_(data), size_(size) {}
    constexpr const T* data() const noexcept { return data_; }
    constexpr std::size_t size() const noexcept { return size_; }
    constexpr bool empty() const noexcept { return size_ == 0; }
    constexpr const T* begin() const noexcept { return data_; }
    constexpr const T* end() const noexcept { return data_ + size_; }
    constexpr const T& operator[](std::size_t index) const noexcept { return data_[index]; }

private:
    const T* data_;
    std::size_t size_;
};

namespace detail {

template <typename T, void (*Free)(T*)>
struct deleter {
    void operator()(T* handle) const noexcept { Free(handle); }
};

template <typename T, void (*Free)(T*)>
using owner = std::unique_ptr<T, deleter<T, Free>>;

}  // namespace detail

/// Why a call failed.
class error {
public:
    error(clearway_status status, clearway_error* handle) noexcept
        : status_(status), handle_(handle) {}

    clearway_status status() const noexcept { return status_; }
    /// For people, with the numbers.
    const char* message() const noexcept { return clearway_error_message(handle_.get()); }
    /// The refusal, if it is one; its texts live as long as this.
    std::optional<clearway_refusal> refusal() const noexcept {
        clearway_refusal found;
        if (!clearway_error_refusal(handle_.get(), &found)) return std::nullopt;
        return found;
    }

private:
    clearway_status status_;
    detail::owner<clearway_error, clearway_error_free> handle_;
};

/// What value() throws for an error.
class exception : public std::runtime_error {
public:
    explicit exception(const error& failed)
        : std::runtime_error(failed.message()), status_(failed.status()) {}
    clearway_status status() const noexcept { return status_; }

private:
    clearway_status status_;
};

/// A value, or why there is none.
template <typename T>
class [[nodiscard]] result {
public:
    result(T value) noexcept : held_(std::in_place_index<0>, std::move(value)) {}
    result(class error failed) noexcept : held_(std::in_place_index<1>, std::move(failed)) {}

    bool has_value() const noexcept { return held_.index() == 0; }
    explicit operator bool() const noexcept { return has_value(); }
    /// Only if has_value().
    T& operator*() & noexcept { return *std::get_if<0>(&held_); }
    const T& operator*() const& noexcept { return *std::get_if<0>(&held_); }
    T* operator->() noexcept { return std::get_if<0>(&held_); }
    const T* operator->() const noexcept { return std::get_if<0>(&held_); }
    /// Only if not has_value().
    const class error& error() const noexcept { return *std::get_if<1>(&held_); }

#if defined(__cpp_exceptions)
    /// The value; throws clearway::exception if there is none.
    T& value() & {
        check();
        return **this;
    }
    T value() && {
        check();
        return std::move(**this);
    }

private:
    void check() const {
        if (!has_value()) throw exception(error());
    }
#endif

private:
    std::variant<T, class error> held_;
};

/// A planned and sampled motion; it lives as long as its reply.
class trajectory {
public:
    explicit trajectory(const clearway_trajectory* handle) noexcept : handle_(handle) {}

    clearway_summary summary() const noexcept { return clearway_trajectory_summary(handle_); }
    std::size_t blocks() const noexcept { return clearway_trajectory_blocks(handle_); }
    /// The samples of a block, where the planner wrote them.
    view<sample> block(std::size_t index) const noexcept {
        const clearway_samples samples = clearway_trajectory_block(handle_, index);
        return {samples.data, samples.count};
    }
    std::size_t legs() const noexcept { return clearway_trajectory_legs(handle_); }
    clearway_leg leg(std::size_t index) const noexcept {
        clearway_leg found{};
        clearway_trajectory_leg(handle_, index, &found);
        return found;
    }
    /// Indices of the channels travelled, in travel order.
    view<std::uint64_t> route() const noexcept {
        std::size_t count = 0;
        const std::uint64_t* route = clearway_trajectory_route(handle_, &count);
        return {route, count};
    }
    /// The gaps used, metres, junction by junction in travel order: gaps_per_junction() for each.
    view<double> gaps() const noexcept {
        std::size_t count = 0;
        const double* gaps = clearway_trajectory_gaps(handle_, &count, nullptr);
        return {gaps, count};
    }
    std::size_t gaps_per_junction() const noexcept {
        std::size_t each = 0;
        clearway_trajectory_gaps(handle_, nullptr, &each);
        return each;
    }
    /// How many channels the planner made, which route() counts; 0 if the scene has them.
    std::size_t channels() const noexcept { return clearway_trajectory_channels(handle_); }
    clearway_box channel(std::size_t index) const noexcept {
        clearway_box found{};
        clearway_trajectory_channel(handle_, index, &found);
        return found;
    }
    /// Calls `visit` with each sample in turn.
    template <typename Visit>
    void for_each_sample(Visit visit) const {
        for (std::size_t index = 0; index < blocks(); ++index)
            for (const sample& found : block(index)) visit(found);
    }

private:
    const clearway_trajectory* handle_;
};

/// An answer for each clearance asked for.
class reply {
public:
    explicit reply(clearway_reply* handle) noexcept : handle_(handle) {}

    std::size_t answers() const noexcept { return clearway_reply_answers(handle_.get()); }
    bool is_shared() const noexcept { return clearway_reply_is_shared(handle_.get()); }
    std::optional<std::uint64_t> id() const noexcept {
        std::uint64_t found;
        if (!clearway_reply_id(handle_.get(), &found)) return std::nullopt;
        return found;
    }
    /// The trajectory of an answer, or its refusal.
    result<class trajectory> trajectory(std::size_t answer = 0) const noexcept {
        const clearway_trajectory* found = nullptr;
        clearway_error* failed = nullptr;
        const auto status = clearway_reply_trajectory(handle_.get(), answer, &found, &failed);
        if (status != CLEARWAY_STATUS_OK) return error(status, failed);
        return clearway::trajectory(found);
    }
    /// As `plan --format json` prints it.
    std::string json() const {
        const detail::owner<char, clearway_text_free> text(clearway_reply_json(handle_.get()));
        return text ? std::string(text.get()) : std::string();
    }

private:
    detail::owner<clearway_reply, clearway_reply_free> handle_;
};

/// A scene, prepared to be planned any number of times.
class scene {
public:
    static result<scene> read(std::string_view json) noexcept {
        clearway_scene* found = nullptr;
        clearway_error* failed = nullptr;
        const auto status = clearway_scene_read(json.data(), json.size(), &found, &failed);
        if (status != CLEARWAY_STATUS_OK) return error(status, failed);
        return scene(found);
    }
    /// With the name of its free space: sent only to planners that do not know it.
    result<scene> with_name() const noexcept {
        clearway_scene* found = nullptr;
        clearway_error* failed = nullptr;
        const auto status = clearway_scene_with_name(handle_.get(), &found, &failed);
        if (status != CLEARWAY_STATUS_OK) return error(status, failed);
        return scene(found);
    }
    const clearway_scene* get() const noexcept { return handle_.get(); }

private:
    explicit scene(clearway_scene* handle) noexcept : handle_(handle) {}
    detail::owner<clearway_scene, clearway_scene_free> handle_;
};

/// A request being answered. Its end cancels it.
class pending {
public:
    explicit pending(clearway_pending* handle) noexcept : handle_(handle) {}

    /// The reply if it is there.
    result<std::optional<reply>> poll() noexcept {
        clearway_reply* found = nullptr;
        clearway_error* failed = nullptr;
        const auto status = clearway_pending_poll(handle_.get(), &found, &failed);
        if (status != CLEARWAY_STATUS_OK) return error(status, failed);
        if (found == nullptr) return std::optional<reply>();
        return std::optional<reply>(reply(found));
    }
    /// Waits for the reply, at most `timeout` seconds.
    result<reply> wait(double timeout) noexcept {
        clearway_reply* found = nullptr;
        clearway_error* failed = nullptr;
        const auto status = clearway_pending_wait(handle_.get(), timeout, &found, &failed);
        if (status != CLEARWAY_STATUS_OK) return error(status, failed);
        return reply(found);
    }
    /// For event loops: when it can be read, poll(); every 0.1 s anyway.
    int fd() const noexcept { return clearway_pending_fd(handle_.get()); }

private:
    detail::owner<clearway_pending, clearway_pending_free> handle_;
};

/// Asks the planner of a domain.
class client {
public:
    /// Connects; nullptr is the default domain. Waits `patience` seconds for a planner.
    static result<client> connect(const char* domain = nullptr, double patience = 0.0) noexcept {
        clearway_client* found = nullptr;
        clearway_error* failed = nullptr;
        const auto status = clearway_connect(domain, patience, &found, &failed);
        if (status != CLEARWAY_STATUS_OK) return error(status, failed);
        return client(found);
    }
    /// Plans a scene, waiting at most `timeout` seconds.
    result<reply> plan(const scene& scene, double timeout) const noexcept {
        clearway_reply* found = nullptr;
        clearway_error* failed = nullptr;
        const auto status = clearway_plan(handle_.get(), scene.get(), timeout, &found, &failed);
        if (status != CLEARWAY_STATUS_OK) return error(status, failed);
        return reply(found);
    }
    /// Sends a scene without waiting.
    result<pending> start(const scene& scene) const noexcept {
        clearway_pending* found = nullptr;
        clearway_error* failed = nullptr;
        const auto status = clearway_start(handle_.get(), scene.get(), &found, &failed);
        if (status != CLEARWAY_STATUS_OK) return error(status, failed);
        return pending(found);
    }

private:
    explicit client(clearway_client* handle) noexcept : handle_(handle) {}
    detail::owner<clearway_client, clearway_client_free> handle_;
};

}  // namespace clearway

#endif
