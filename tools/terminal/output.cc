#include "tools/terminal/output.h"

#include <nlohmann/json.hpp>

namespace palpate {

std::string event_line(const nlohmann::ordered_json& event) {
    return event.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
}

}  // namespace palpate
