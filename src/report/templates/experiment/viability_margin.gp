# names: the tempos
array stretches[3] = [0, 1, 0.84]
tempo = "stretch of the brisk trajectory [-]"
marked(i) = column(tempo) == stretches[i] && column("kept back [bits]") != 0 ? column("t [s]") : NaN
@canvas 1000,750
set multiplot layout 3,1 title 'Margin over a trajectory' @heading
do for [i = 1:3] {
  @panel
  set title names[i].', bursts of 19'
  set xlabel 't [s]'
  set ylabel 'least margin'
  set yrange [-0.05:0.5]
  plot $data using (of(tempo, stretches[i], "t [s]")):"margin [-]" @line lc rgb series(1) title i == 1 ? 'margin' : '', \
    '' using (marked(i)):(0) @points lc rgb series(3) title i == 1 ? 'kept back' : ''
}
