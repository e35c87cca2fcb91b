#compdef panda-twin
{{#commands}}

_{{{function}}}() {
  local context state line
  _arguments -C \
{{#options}}    '{{#is_positional}}*{{/is_positional}}{{#is_flag}}{{{name}}}[{{text}}]{{/is_flag}}{{#has_value}}:{{type}}:{{#is_file}}_files{{/is_file}}{{#is_folder}}_files -/{{/is_folder}}{{#is_word}}({{{words}}}){{/is_word}}{{/has_value}}' \
{{/options}}{{^has_commands}}    && return
}
{{/has_commands}}{{#has_commands}}    '1: :->command' '*:: :->arguments' && return
  case $state in
    command)
      local -a commands=({{#commands}} '{{{name}}}:{{text}}'{{/commands}} )
      _describe command commands ;;
    arguments) _{{{function}}}_$words[1] ;;
  esac
}
{{/has_commands}}{{/commands}}

_panda-twin "$@"
