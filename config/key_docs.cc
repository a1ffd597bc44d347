#include "config/key_docs.h"

#include "config/internal/key_table.h"
#include "config/internal/session_keys.h"

namespace palpate {

std::vector<KeyDoc> documented_keys() {
    std::vector<KeyDoc> docs;
    yaml::KeyTable table(docs, "");
    SessionConfig defaults;
    describe(table, defaults);
    return docs;
}

}  // namespace palpate
