# Writes OUTPUT, a C++ file with the bytes of FILES as server/http/pages.h declares them.
# Run at build time: cmake -DOUTPUT=... -DFILES=index.html|app.js -P EmbedPages.cmake
set(arrays "")
set(table "")
string(REPLACE "|" ";" FILES "${FILES}")
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME)
  string(MAKE_C_IDENTIFIER ${name} variable)
  file(READ ${file} bytes HEX)
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
  # Lines that tools can show.
  string(REGEX REPLACE "(0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,)" "\\1\n" bytes "${bytes}")
  string(APPEND arrays "const unsigned char k_${variable}[] = {\n${bytes}};\n")
  string(APPEND table "    {\"${name}\", {reinterpret_cast<const char*>(k_${variable}), sizeof(k_${variable})}},\n")
endforeach()
file(WRITE ${OUTPUT} "// Generated from client/web/dist; do not edit.
#include \"server/http/pages.h\"

namespace axiscal::http {
namespace {

${arrays}
}  // namespace

std::vector<EmbeddedFile> EmbeddedPages() {
  return {
${table}  };
}

}  // namespace axiscal::http
")
