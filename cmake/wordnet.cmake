# WordNet's nouns for what one can touch, baked into the library (src/query/wordnet.h): what a word is a kind of. From
# Debian's wordnet-base; without it the layer is empty and queries know the words of the alias files only.
set(WORDNET_SOURCE ${CMAKE_BINARY_DIR}/generated/wordnet_text.cpp)
find_package(Python3 COMPONENTS Interpreter QUIET)
find_path(WORDNET_DIR data.noun PATHS /usr/share/wordnet NO_DEFAULT_PATH)
if(WORDNET_DIR AND Python3_FOUND)
  add_custom_command(
    OUTPUT ${WORDNET_SOURCE}
    COMMAND ${Python3_EXECUTABLE} -B ${PROJECT_SOURCE_DIR}/cmake/bake_wordnet.py ${WORDNET_DIR} ${WORDNET_SOURCE}
    DEPENDS ${PROJECT_SOURCE_DIR}/cmake/bake_wordnet.py ${WORDNET_DIR}/data.noun)
else()
  message(STATUS "WordNet: not found (package wordnet-base): queries will know only the words of the alias files")
  file(CONFIGURE OUTPUT ${WORDNET_SOURCE} CONTENT "#include <string_view>
namespace hgg {
extern const std::string_view kWordnetText;
const std::string_view kWordnetText = \"\";
}  // namespace hgg
")
endif()
