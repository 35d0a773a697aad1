#ifndef INSONIFY_EXAMPLES_LIVE_SLICER_CONNECTION_HPP
#define INSONIFY_EXAMPLES_LIVE_SLICER_CONNECTION_HPP

#include "requests.hpp"
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <deque>
#include <memory>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

namespace slicer {

using shared_bytes = std::shared_ptr<const bytes>;
using steady = std::chrono::steady_clock;

/// What belongs to one picture.
struct frame_messages {
    shared_bytes transforms{}, image{};
};

/// One client: reads messages as they come, and sends what the socket takes. Nothing blocks.
///
/// A client that reads slowly gets fewer pictures, never old ones: a picture that has not begun to be sent is replaced by
/// the next one. Answers are all sent.
class connection {
  public:
    static constexpr auto message_time = std::chrono::seconds{5}; ///< for a whole message to arrive
    static constexpr auto stall_time = std::chrono::seconds{5};   ///< in which the client must take something
    static constexpr std::size_t max_unread = 256 * 1024;         ///< bytes of answers that wait

    explicit connection(int descriptor) : socket_{descriptor} { input_.reserve(header_size); }
    connection(const connection&) = delete;
    connection& operator=(const connection&) = delete;
    ~connection() { ::close(socket_); }

    int socket() const { return socket_; }
    bool wants_to_send() const { return current_ || !answers_.empty() || next_.transforms || next_.image; }

    /// Passes each complete message to `take(header, body)`, at most 64 KiB at a time, so that all clients have their turn.
    /// @return false where the client has closed
    /// @throws broken_stream  where the bytes are no messages
    template <class Take>
    bool receive(const Take& take) {
        unsigned char read[16 * 1024];
        for (int turn = 0; turn < 4; ++turn) {
            const ssize_t size = ::recv(socket_, read, sizeof read, MSG_DONTWAIT);
            if (size == 0) return false;
            if (size < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
            digest(read, static_cast<std::size_t>(size), take);
            if (static_cast<std::size_t>(size) < sizeof read) break;
        }
        return true;
    }

    void answer(bytes message) {
        note_begin();
        waiting_ += message.size();
        answers_.push_back(std::make_shared<const bytes>(std::move(message)));
    }
    /// Replaces what has not begun to be sent of the frame before.
    void offer(const frame_messages& frame) {
        note_begin();
        if (frame.transforms) next_.transforms = frame.transforms;
        if (frame.image) next_.image = frame.image;
    }

    /// Sends until the socket is full.
    /// @return false where the client is gone
    bool send() {
        while (choose()) {
            const ssize_t size =
                ::send(socket_, current_->data() + sent_, current_->size() - sent_, MSG_DONTWAIT | MSG_NOSIGNAL);
            if (size < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
            progress_ = steady::now();
            sent_ += static_cast<std::size_t>(size);
            if (sent_ == current_->size()) current_.reset();
        }
        return true;
    }

    /// @throws broken_stream  for a client that is too slow, or leaves too many answers unread
    void check(steady::time_point time) const {
        if (waiting_ > max_unread) throw broken_stream{"it does not read its answers"};
        if (wants_to_send() && time - progress_ > stall_time) throw broken_stream{"it has read nothing for 5 s"};
        if (!input_.empty() && time - begun_ > message_time) throw broken_stream{"a message has taken more than 5 s"};
    }

    bool pictures = true; ///< wanted: STT_IMAGE, STP_IMAGE

  private:
    template <class Take>
    void digest(const unsigned char* read, std::size_t size, const Take& take) {
        while (size > 0) {
            if (input_.empty()) begun_ = steady::now();
            if (input_.size() < header_size) {
                move_to_input(read, size, header_size);
                if (input_.size() < header_size) return;
                head_ = read_header(input_.data());
                left_ = head_.body_size;
            }
            if (is_understood(head_.type)) {
                const std::size_t before = input_.size();
                move_to_input(read, size, header_size + static_cast<std::size_t>(head_.body_size));
                left_ -= input_.size() - before;
            } else { // skipped, not stored
                const std::size_t skipped = std::min<std::size_t>(size, static_cast<std::size_t>(left_));
                read += skipped;
                size -= skipped;
                left_ -= skipped;
            }
            if (left_ > 0) return;
            bytes body{input_.begin() + header_size, input_.end()};
            input_.clear();
            take(head_, std::move(body));
        }
    }
    void move_to_input(const unsigned char*& read, std::size_t& size, std::size_t until) {
        const std::size_t moved = std::min(size, until - input_.size());
        input_.insert(input_.end(), read, read + moved);
        read += moved;
        size -= moved;
    }

    // Chooses what is sent next; answers precede pictures.
    bool choose() {
        if (current_) return true;
        sent_ = 0;
        if (!answers_.empty()) {
            current_ = std::move(answers_.front());
            answers_.pop_front();
            waiting_ -= current_->size();
        } else if (next_.transforms) {
            current_ = std::exchange(next_.transforms, nullptr);
        } else if (next_.image) {
            current_ = std::exchange(next_.image, nullptr);
        }
        return current_ != nullptr;
    }
    // The time in which something must be taken begins when there is something to take.
    void note_begin() {
        if (!wants_to_send()) progress_ = steady::now();
    }

    int socket_;
    bytes input_{}; // of the message that is arriving: header and, where it is understood, body
    header head_{};
    std::uint64_t left_ = 0; // of its body
    steady::time_point begun_{}, progress_ = steady::now();
    std::deque<shared_bytes> answers_{};
    std::size_t waiting_ = 0, sent_ = 0;
    shared_bytes current_{};
    frame_messages next_{};
};

} // namespace slicer

#endif
