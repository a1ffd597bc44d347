#include "tools/commands/usage.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string_view>
#include <vector>

#include "config/nearest_word.h"

namespace palpate {
namespace {

bool is_option(const std::string& word) { return word.size() > 1 && word.front() == '-'; }

// "output" of "--output=DIR".
std::string_view bare(std::string_view option) {
    option.remove_prefix(std::min(option.find_first_not_of('-'), option.size()));
    return option.substr(0, option.find('='));
}

// The likely option of an app, with its dashes; empty if none is likely.
std::string nearest_option(const CLI::App& app, std::string_view typed) {
    std::vector<std::string_view> known;
    for (const CLI::Option* option : app.get_options()) known.insert(known.end(), option->get_lnames().begin(), option->get_lnames().end());
    const std::string_view nearest = nearest_word(bare(typed), known);
    return nearest.empty() ? "" : fmt::format("--{}", nearest);
}

// What was typed where a command is expected.
std::string explain_command(const CLI::App& app, const std::string& typed) {
    if (is_option(typed)) {
        return fmt::format("{}: unknown option {}{}\nAll options and commands: {} --help\n", app.get_name(), typed,
                           proposal(nearest_option(app, typed)), app.get_name());
    }
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
    const std::vector<std::string_view> known(names.begin(), names.end());
    std::string likely(nearest_word(typed, known));
    // Other programs have `help` and `version` as commands.
    if (likely.empty()) likely = nearest_option(app, typed);
    if (is_option(likely)) likely = fmt::format("{} {}", app.get_name(), likely);
    return fmt::format("{}: unknown command \"{}\"{}\nAll commands: {} --help\n", app.get_name(), typed, proposal(likely), app.get_name());
}

// What a command has no use for.
std::string explain_rest(const CLI::App& app, const CLI::App& command, const std::vector<std::string>& words) {
    const std::string help = fmt::format("{} {} --help", app.get_name(), command.get_name());
    // The value of an unknown option is left over, too: the option is the mistake.
    const auto option = std::ranges::find_if(words, is_option);
    if (option == words.end()) {
        return fmt::format("{}: one word too many for {}: {}\nWhat it takes: {}\n", app.get_name(), command.get_name(), words.front(),
                           help);
    }
    return fmt::format("{}: {} has no option {}{}\nIts options: {}\n", app.get_name(), command.get_name(), *option,
                       proposal(nearest_option(command, *option)), help);
}

std::string short_help(const CLI::App& app) {
    std::string text = fmt::format("{}\nUsage: {} COMMAND ...\n", app.get_description(), app.get_name());
    for (const CLI::App* command : app.get_subcommands({})) {
        text += fmt::format("  {:<10}{}\n", command->get_name(), command->get_description());
    }
    return text + fmt::format("Examples and exit codes: {0} --help; one command: {0} COMMAND --help\n", app.get_name());
}

// Words that nothing took, without the mark that ends options.
std::vector<std::string> left_over(const CLI::App& app) {
    std::vector<std::string> words = app.remaining();
    std::erase(words, "--");
    return words;
}

}  // namespace

std::string explain_usage(const CLI::App* app, const CLI::Error& error) {
    if (const auto words = left_over(*app); !words.empty()) return explain_command(*app, words.front());
    const std::vector<CLI::App*> commands = app->get_subcommands();  // the one that was given
    if (commands.empty()) return short_help(*app);
    const CLI::App& command = *commands.front();
    if (const auto words = left_over(command); !words.empty()) return explain_rest(*app, command, words);
    return fmt::format("{0} {1}: {2}\nHow it is used: {0} {1} --help\n", app->get_name(), command.get_name(), error.what());
}

std::string explain_option_as_name(const std::string& value) {
    if (!value.starts_with('-')) return {};
    return fmt::format("\"{0}\" looks like an option; give a name, and {0} before or after; a name that begins so is written ./{0}", value);
}

}  // namespace palpate
