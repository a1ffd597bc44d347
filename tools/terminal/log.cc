#include "tools/terminal/log.h"

#include <fmt/format.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>

#include "tools/terminal/progress_display.h"

namespace palpate {
namespace {

constexpr std::string_view kWarningColour = "\x1b[33m";
constexpr std::string_view kPlainColour = "\x1b[0m";

class Sink final : public spdlog::sinks::base_sink<std::mutex> {
public:
    explicit Sink(Output& output) : output_(output), colours_(DisplayTraits::of(STDERR_FILENO).colours) {}

protected:
    void sink_it_(const spdlog::details::log_msg& message) override {
        const std::string_view text(message.payload.data(), message.payload.size());
        const std::string_view name(spdlog::level::to_string_view(message.level).data());
        const bool is_warning = message.level >= spdlog::level::warn;
        if (output_.events != nullptr) {
            const nlohmann::ordered_json event = {{"event", "message"}, {"level", name}, {"text", text}};
            output_.events->write(event_line(event));
        }
        const bool is_coloured = colours_ && is_warning;
        output_.console.write(
            fmt::format("palpate: {}{}{}: {}\n", is_coloured ? kWarningColour : "", name, is_coloured ? kPlainColour : "", text));
    }
    void flush_() override {}

private:
    Output& output_;
    const bool colours_;
};

}  // namespace

void log_to(Output& output) {
    const auto log = std::make_shared<spdlog::logger>("palpate", std::make_shared<Sink>(output));
    if (output.is_quiet) log->set_level(spdlog::level::warn);
    spdlog::set_default_logger(log);
}

}  // namespace palpate
