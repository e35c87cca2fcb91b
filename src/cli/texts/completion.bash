_panda_twin() {
  local word=${COMP_WORDS[COMP_CWORD]} path='' words='' flags='' i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "${path:+$path }${COMP_WORDS[i]}" in
      {{{paths}}}) path="${path:+$path }${COMP_WORDS[i]}" ;;
    esac
  done
  case "$path/${COMP_WORDS[COMP_CWORD-1]}" in
{{#commands}}{{#options}}{{#is_flag}}{{#is_word}}    '{{{path}}}/{{{name}}}') words='{{{words}}}' ;;
{{/is_word}}{{/is_flag}}{{/options}}{{#values}}    {{{values}}}) compopt +o default ;;
{{/values}}{{#files}}    {{{files}}}) ;;
{{/files}}    '{{{path}}}/'*) words='{{#commands}}{{{name}}} {{/commands}}{{#options}}{{#is_positional}}{{#is_word}}{{{words}}}{{/is_word}}{{/is_positional}}{{/options}}' flags='{{#options}}{{#is_flag}}{{{name}}} {{/is_flag}}{{/options}}' ;;
{{/commands}}  esac
  [[ $word == -* ]] && words=$flags
  COMPREPLY=($(compgen -W "$words" -- "$word"))
}
complete -o default -F _panda_twin panda-twin
