# Embeds the page at / at build time: cmake -D HTML=.. -D SCRIPT=.. -D STYLE=.. -D TEMPLATE=.. -D OUTPUT=.. -P EmbedPage.cmake
include(${CMAKE_CURRENT_LIST_DIR}/EmbedText.cmake)
foreach(part HTML SCRIPT STYLE)
  sightline_embed_text(${part} ${${part}})
endforeach()
configure_file(${TEMPLATE} ${OUTPUT} @ONLY)
