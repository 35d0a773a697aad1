#ifndef INSONIFY_EXAMPLES_LIVE_SLICER_SERVER_HPP
#define INSONIFY_EXAMPLES_LIVE_SLICER_SERVER_HPP

#include "connection.hpp"
#include <arpa/inet.h>
#include <atomic>
#include <cstdio>
#include <deque>
#include <fcntl.h>
#include <map>
#include <mutex>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <system_error>
#include <thread>
#include <variant>

namespace slicer {

/// Something that only the simulator can answer.
struct request {
    std::uint64_t client = 0;
    header head{};
    std::variant<pose, command> asked{};
};

/// The sockets, on one thread that sleeps in poll(). `publish`, `answer` and `take` may be called from any other thread;
/// they never wait for a client.
class server {
  public:
    static constexpr std::size_t max_clients = 64;
    static constexpr std::size_t max_requests = 64;        ///< of a client, that wait
    static constexpr std::size_t max_waiting = 256 * 1024; ///< bytes of the commands of a client, that wait
    static constexpr std::size_t max_senders = 256; ///< clients of which something waits, those that have gone included

    /// Listens on all interfaces.
    /// @param port  0: any that is free
    /// @throws std::system_error  where the port is in use
    explicit server(std::uint16_t port) {
        listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
        const int on = 1;
        ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_ANY);
        address.sin_port = htons(port);
        if (listener_ < 0 || ::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
            ::listen(listener_, 128) != 0 || ::pipe2(wake_.data(), O_NONBLOCK | O_CLOEXEC) != 0) {
            const std::system_error fault{errno, std::generic_category(), "--port " + std::to_string(port)};
            if (listener_ >= 0) ::close(listener_);
            throw fault;
        }
        socklen_t size = sizeof address;
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
        port_ = ntohs(address.sin_port);
        thread_ = std::thread{[this] { run(); }};
    }
    server(const server&) = delete;
    server& operator=(const server&) = delete;
    ~server() {
        stopped_ = true;
        wake();
        thread_.join();
        for (const int descriptor : {listener_, wake_[0], wake_[1]}) ::close(descriptor);
    }

    std::uint16_t port() const { return port_; }
    std::size_t clients() const { return count_; }

    /// Sends a picture to all clients that want one.
    /// @param status  the sentence that answers GET_STATUS
    void publish(frame_messages frame, const std::string& status) {
        const std::scoped_lock lock{mutex_};
        frame_ = std::move(frame);
        status_ = status;
        is_new_ = true;
        wake();
    }
    /// Answers a request. An empty message means that there is nothing to say.
    void answer(const request& to, bytes message) {
        const std::scoped_lock lock{mutex_};
        answers_.emplace_back(to.client, std::move(message));
        wake();
    }
    /// The next of what clients have asked for: a request of each client in turn.
    std::optional<request> take() {
        const std::scoped_lock lock{mutex_};
        auto from = requests_.upper_bound(served_);
        if (from == requests_.end()) from = requests_.begin();
        if (from == requests_.end()) return std::nullopt;
        served_ = from->first;
        request next = std::move(from->second.front());
        from->second.pop_front();
        if (from->second.empty()) requests_.erase(from);
        return next;
    }

  private:
    void wake() const {
        const char any = 0;
        [[maybe_unused]] const ssize_t written = ::write(wake_[1], &any, 1); // a full pipe wakes, too
    }

    void run() {
        std::vector<pollfd> watched;
        while (!stopped_) {
            watched.assign(
                {{wake_[0], POLLIN, 0},
                 {clients_.size() < max_clients && steady::now() >= accept_after_ ? listener_ : -1, POLLIN, 0}});
            for (const auto& [number, one] : clients_)
                watched.push_back(
                    {one->socket(), static_cast<short>(one->wants_to_send() ? POLLIN | POLLOUT : POLLIN), 0});
            ::poll(watched.data(), watched.size(), 500);
            char drained[256];
            while (::read(wake_[0], drained, sizeof drained) > 0) {
            }
            distribute();
            std::size_t i = 2;
            for (auto each = clients_.begin(); each != clients_.end(); ++i)
                each =
                    serve(each->first, *each->second, watched[i].revents != 0) ? std::next(each) : clients_.erase(each);
            if (watched[1].revents != 0)
                while (clients_.size() < max_clients && accept_client()) {
                }
            count_ = clients_.size();
        }
    }

    // Hands out what the simulator has made.
    void distribute() {
        const std::scoped_lock lock{mutex_};
        for (auto& [number, message] : std::exchange(answers_, {})) {
            const auto to = clients_.find(number);
            if (to == clients_.end()) continue;
            if (!message.empty()) to->second->answer(std::move(message));
        }
        if (std::exchange(is_new_, false))
            for (auto& [number, one] : clients_)
                one->offer({frame_.transforms, one->pictures ? frame_.image : nullptr});
    }

    // False where the client has gone or is disconnected.
    bool serve(std::uint64_t number, connection& one, bool is_readable) {
        try {
            if (is_readable &&
                !one.receive([&](const header& head, bytes body) { understand(number, one, head, std::move(body)); }))
                return false;
            if (!one.send()) return false;
            one.check(steady::now());
            return true;
        } catch (const broken_stream& fault) {
            std::fprintf(stderr, "client %llu is disconnected: %s\n", static_cast<unsigned long long>(number),
                         fault.what());
            return false;
        }
    }

    void understand(std::uint64_t number, connection& one, const header& head, bytes body) {
        try {
            if (head.type == "GET_STATUS") {
                const std::scoped_lock lock{mutex_};
                return one.answer(pack_status(igtl::StatusMessage::STATUS_OK, status_));
            }
            if (head.type == "STT_IMAGE" || head.type == "STP_IMAGE") {
                one.pictures = head.type == "STT_IMAGE";
                return one.answer(pack_accepted("RTS_IMAGE"));
            }
            if (head.type == "GET_IMAGE" || head.type == "GET_TRANS") {
                const std::scoped_lock lock{mutex_};
                return one.offer(head.type == "GET_IMAGE" ? frame_messages{nullptr, frame_.image}
                                                          : frame_messages{frame_.transforms, nullptr});
            }
            if (head.type == "STATUS") return; // a sign of life
            if (!is_understood(head.type))
                throw refused_message{igtl::StatusMessage::STATUS_UNKNOWN_INSTRUCTION,
                                      head.type + " is not understood; TRANSFORM, COMMAND and STRING are"};
            const bytes content = read_content(head, std::move(body));
            request next{.client = number, .head = head};
            if (head.type == "TRANSFORM")
                next.asked = read_transform(head, content);
            else
                next.asked = read_command(head, content);
            queue(std::move(next));
        } catch (const refused_message& fault) {
            one.answer(pack_status(fault.code, fault.what()));
        }
    }

    // A pose replaces an earlier one of the same name that has not been used.
    void queue(request next) {
        const std::scoped_lock lock{mutex_};
        const auto found = requests_.find(next.client);
        std::size_t bytes_waiting = text_size(next);
        if (found != requests_.end())
            for (request& waiting : found->second) {
                bytes_waiting += text_size(waiting);
                if (std::holds_alternative<pose>(next.asked) && waiting.head.type == next.head.type &&
                    waiting.head.device == next.head.device) {
                    waiting.asked = next.asked;
                    return;
                }
            }
        if (bytes_waiting > max_waiting ||
            (found != requests_.end() ? found->second.size() >= max_requests : requests_.size() >= max_senders))
            throw refused_message{igtl::StatusMessage::STATUS_BUSY, "too many requests at once"};
        requests_[next.client].push_back(std::move(next));
    }
    static std::size_t text_size(const request& one) {
        const auto* const asked = std::get_if<command>(&one.asked);
        return asked == nullptr ? 0 : asked->text.size();
    }

    bool accept_client() {
        const int descriptor = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
        if (descriptor < 0) {
            if (errno != EAGAIN && errno != EWOULDBLOCK) // no descriptor is free: the listener stays readable
                accept_after_ = steady::now() + std::chrono::milliseconds{500};
            return false;
        }
        const int on = 1, buffer = 128 * 1024; // a small buffer: pictures do not age in it
        ::setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        ::setsockopt(descriptor, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
        ::setsockopt(descriptor, SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
        auto& one = clients_[++last_number_];
        one = std::make_unique<connection>(descriptor);
        const std::scoped_lock lock{mutex_};
        one->answer(pack_status(igtl::StatusMessage::STATUS_OK, status_));
        one->offer(frame_);
        return true;
    }

    std::array<int, 2> wake_{-1, -1};
    int listener_ = -1;
    std::uint16_t port_ = 0;
    std::atomic<bool> stopped_ = false;
    std::atomic<std::size_t> count_ = 0;
    std::map<std::uint64_t, std::unique_ptr<connection>> clients_{}; // of the thread, as are the next two
    std::uint64_t last_number_ = 0;
    steady::time_point accept_after_{};

    std::mutex mutex_{}; // of what follows
    frame_messages frame_{};
    std::string status_ = "starting";
    bool is_new_ = false;
    std::vector<std::pair<std::uint64_t, bytes>> answers_{};
    std::map<std::uint64_t, std::deque<request>> requests_{}; // of each client
    std::uint64_t served_ = 0;                                // the client of the last one taken
    std::thread thread_{};
};

} // namespace slicer

#endif
