# Embeds the pages at / and /learn at build time: cmake -D HTML=.. -D SCRIPT=.. -D STYLE=.. -D LEARN_HTML=.. -D LEARN_SCRIPT=..
#   -D TEMPLATE=.. -D OUTPUT=.. -P EmbedPage.cmake
include(${CMAKE_CURRENT_LIST_DIR}/EmbedText.cmake)
foreach(part HTML SCRIPT STYLE LEARN_HTML LEARN_SCRIPT)
  sightline_embed_text(${part} ${${part}})
endforeach()
configure_file(${TEMPLATE} ${OUTPUT} @ONLY)
