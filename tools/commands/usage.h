// What is said to whoever mistypes a command line.
#pragma once

#include <string>

namespace CLI {
class App;
class Error;
}  // namespace CLI

namespace palpate {

// For CLI::App::failure_message: names the word that is none, proposes the likely one, and says where to go on. Without any word, which
// commands there are.
[[nodiscard]] std::string explain_usage(const CLI::App* app, const CLI::Error& error);

// For values that are names: an option in their place is one, whose own name was forgotten. Empty if `value` may be a name.
[[nodiscard]] std::string explain_option_as_name(const std::string& value);

}  // namespace palpate
