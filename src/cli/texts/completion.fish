complete -c panda-twin -n __fish_use_subcommand -f
{{#commands}}{{#commands}}complete -c panda-twin -n '{{{when}}}{{^is_program}}; and not __fish_seen_subcommand_from{{#commands}} {{{name}}}{{/commands}}{{/is_program}}' -f -a {{{name}}} -d '{{text}}'
{{/commands}}{{#options}}{{#is_positional}}{{#is_word}}complete -c panda-twin -n '{{{when}}}' -f -a '{{words}}'
{{/is_word}}{{/is_positional}}{{#is_flag}}complete -c panda-twin -n '{{{when}}}' -l {{{long}}}{{#is_path}} -r{{/is_path}}{{#is_text}} -x{{/is_text}}{{#is_word}} -x -a '{{words}}'{{/is_word}} -d '{{text}}'
{{/is_flag}}{{/options}}{{/commands}}
