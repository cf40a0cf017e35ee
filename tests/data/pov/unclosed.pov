camera {{{ "unclosed
