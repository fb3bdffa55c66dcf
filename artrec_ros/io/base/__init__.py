"""What every room of files uses: strict YAML, whole files, kinds of files, where shipped ones lie."""
