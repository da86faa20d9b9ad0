# SPDX-License-Identifier: BSD-3-Clause
# bash completion for the programs and scripts of openhrp-dds: source it. It asks the programs (--help), so it knows what
# they know; files complete as usual.

# _hrp_help PROGRAM [COMMAND]: its --help, with "~/" and relative paths as typed.
_hrp_help() { "${1/#\~/$HOME}" "${@:2}" --help 2> /dev/null; }

# _hrp_commands PROGRAM: names under "Subcommands:".
_hrp_commands() { _hrp_help "$1" | awk '/^Subcommands:/ { on = 1; next } on && /^  [a-z]/ { print $1 } on && /^[A-Z]/ { exit }'; }

_hrp() {
  local program="${COMP_WORDS[0]}" word="${COMP_WORDS[COMP_CWORD]}" previous="${COMP_WORDS[COMP_CWORD - 1]}"
  local commands command="" i help
  COMPREPLY=()
  commands="$(_hrp_commands "$program")"
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case " ${commands//$'\n'/ } " in *" ${COMP_WORDS[i]} "*) command="${COMP_WORDS[i]}" ;; esac
  done
  help="$(_hrp_help "$program" $command)"
  # The values of an option that has a list of them: "--dds TEXT:{cyclone,fast}".
  if [ "${previous#--}" != "$previous" ]; then
    local values
    values="$(grep -oE -- "$previous [A-Z]+:\{[^}]*\}" <<< "$help" | head -n 1 | sed 's/.*{//; s/}//; s/,/ /g')"
    if [ -n "$values" ]; then COMPREPLY=($(compgen -W "$values" -- "$word")); return; fi
  fi
  if [ "${word#-}" != "$word" ]; then
    COMPREPLY=($(compgen -W "$(grep -oE -- '(^|[ ,[])--[a-z][a-z-]*' <<< "$help" | grep -oE -- '--[a-z-]+' | sort -u)" -- "$word"))
  elif [ -n "$commands" ] && [ -z "$command" ]; then
    COMPREPLY=($(compgen -W "$commands" -- "$word"))
  fi
}

complete -o default -F _hrp hrp-simulate hrp-run hrp-topic hrp-doctor hrp-log hrp-plot hrp-trial hrp-viewer hrp-diagnose hrp-draft-experiment hrp-identify-foot \
  hrp-model-parser hrp-scheduler hrp-logger hrp-dynamics hrp-dynamics-mujoco hrp-collision-checker hrp-vision hrp-controller hrp-controller-ros hrp-make-cases \
  my-controller simulate.sh view.sh diagnose.sh experiments.sh identify_foot.sh build.sh test.sh install_deps.sh prove_concealed.sh secure.sh sanitize.sh fuzz.sh tidy.sh nightly.sh
